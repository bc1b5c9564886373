//! The method that fits networks by sub-model.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Observer, SharedObserver};
use granum_core::parallel;
use granum_nets::ModelDefinition;
use granum_nets::trainer::{Options, SharedTrainer};

use super::fitted::SubModelNetworks;
use super::mapping::NetworkMapping;
use super::training::{FEWEST_STATES, NetworkTask, network_seed};
use super::training_rows::{Rule, TrainingStates, first_ratio};
use super::weighing::weighed;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::surrogate::checkpoints::{NetworkCheckpoints, NoCheckpoints};
use crate::surrogate::settings::Form;
use crate::surrogate::settings::NetworkSettings;
use crate::surrogate::{Columns, Content, FitSpec, Surrogate, SurrogateMethod};

/// Networks of one column or one histogram, each for a range of the coordinate ([`FitSpec::sub_models`]); without sub-models one
/// network for all states.
///
/// The name of the fit and the number of the sub-model give the name of a network, from which its initial weights follow.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::networks::{NetworksBySubModel, SubModel, networks_of};
/// use granum_learn::{Dataset, FitSpec, RunStates, SurrogateMethod};
///
/// let x: Vec<f64> = (0..40).map(|k| f64::from(k) / 39.0).collect();
/// let y = x.iter().map(|x| (6.0 * x).sin()).collect();
/// let dataset = Dataset::new(vec![RunStates::new("run", Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?)?])?;
/// let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
/// let spec = spec.with_sub_models(SubModel::divided([0.0, 1.0], &[0.4], &[4]));
/// let fitted = NetworksBySubModel::default().fit(&dataset, &spec, &mut NoObserver)?;
/// let networks = networks_of(fitted.as_ref()).unwrap();
/// assert_eq!(networks.networks().len(), 2);
/// assert!((networks.predict_row(&[0.7], 0.9)?.value - 4.2f64.sin()).abs() < 0.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NetworksBySubModel {
    /// Its name in the registry and in files.
    pub name: String,
    /// What marks the name of a network whose only input is the coordinate.
    pub coordinate_only_mark: String,
    /// Form in which histograms enter the networks.
    pub form: Form,
    /// The trainer. The initial regularisation and the number of epochs depend on the network; they are passed to the trainer
    /// by [`granum_nets::trainer::Trainer::adapted`].
    pub trainer: SharedTrainer,
    /// Which states a network learns from.
    pub rule: Rule,
    /// Factor on the numbers of epochs of the sub-models; `None` for the trainer's own stopping rule.
    pub epoch_factor: Option<f64>,
    /// Numbers of neurons of the hidden layers, if there are no sub-models (10 and 10).
    pub hidden: Vec<usize>,
}

/// Name of the method in the registry.
const NAME: &str = "sub-models";

impl Default for NetworksBySubModel {
    fn default() -> Self {
        NetworksBySubModel {
            name: NAME.into(),
            coordinate_only_mark: "coordinate-only".into(),
            form: Form::Point,
            trainer: SharedTrainer::default(),
            rule: Rule::Pooled,
            epoch_factor: None,
            hidden: vec![10, 10],
        }
    }
}

impl NetworksBySubModel {
    /// The name of the fit in the names of networks.
    fn name_of_fit(&self, mapping: &NetworkMapping) -> String {
        match mapping.inputs.len() {
            1 => format!("{}-{}", mapping.name, self.coordinate_only_mark),
            _ => mapping.name.clone(),
        }
    }

    fn mapping(&self, dataset: &Dataset, spec: &FitSpec) -> Result<NetworkMapping> {
        NetworkMapping::new(dataset, spec, self.form, &self.hidden)
    }

    /// The network of a sub-model that is to be trained.
    fn task(&self, states: &TrainingStates, spec: &FitSpec, k: usize) -> Result<NetworkTask> {
        let mapping = states.mapping;
        let sub_model = &mapping.sub_models[k];
        let name = format!("{}-{}", self.name_of_fit(mapping), k + 1);
        check_count(states, k)?;
        let failed = |error: granum_nets::DataError| LearnError::Network {
            network: name.clone(),
            reason: error.to_string(),
        };
        let data = states.data(k, self.rule).map_err(failed)?;
        let epochs = self.epoch_factor.zip(sub_model.epochs);
        let epochs = epochs.map(|(factor, epochs)| libm::round(epochs as f64 * factor).max(1.0) as u64);
        let settings = Options { epochs, first_ratio: first_ratio(mapping), ..Options::default() };
        let definition = ModelDefinition {
            inputs: mapping.network_inputs(),
            output: mapping.network_output(),
            quantities: states.quantities(self.rule),
            shares: states.shares(self.rule)?,
            hidden: sub_model.hidden.clone(),
            seed: network_seed(spec.seed, &name),
        };
        let trainer = self.trainer.adapted(&settings).unwrap_or_else(|| self.trainer.clone());
        let kept_as = spec.network_kept_as(&(k + 1).to_string());
        Ok(NetworkTask { name, kept_as, definition, data, trainer, epochs })
    }
}

/// Refuses a sub-model with too few training states.
fn check_count(states: &TrainingStates, k: usize) -> Result<()> {
    let (mapping, found) = (states.mapping, states.count_in(k));
    if found >= FEWEST_STATES {
        return Ok(());
    }
    let [low, high] = mapping.sub_models[k].range;
    Err(LearnError::TooFewStates {
        mapping: mapping.name.clone(),
        sub_model: k + 1,
        coordinate: mapping.coordinate_name().to_owned(),
        low,
        high,
        found,
        needed: FEWEST_STATES,
    })
}

impl SurrogateMethod for NetworksBySubModel {
    fn name(&self) -> &str {
        &self.name
    }

    fn help(&self) -> &str {
        "networks of a column or a histogram, each for a range of the coordinate"
    }

    fn with_networks(&self, settings: &NetworkSettings) -> Result<Option<Arc<dyn SurrogateMethod>>> {
        let (trainer, form, hidden) = (settings.trainer()?, settings.form, settings.hidden.clone());
        Ok(Some(Arc::new(NetworksBySubModel { trainer, form, hidden, ..self.clone() })))
    }

    fn check(&self, dataset: &Dataset, spec: &FitSpec) -> Result<()> {
        let mapping = self.mapping(dataset, spec)?;
        let states = TrainingStates::new(&mapping, dataset)?;
        (0..mapping.sub_models.len()).try_for_each(|k| check_count(&states, k))
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        self.fit_resumable(dataset, spec, observer, &NoCheckpoints)
    }

    fn fit_resumable(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
        checkpoints: &dyn NetworkCheckpoints,
    ) -> Result<Box<dyn Surrogate>> {
        let mapping = self.mapping(dataset, spec)?;
        let states = TrainingStates::new(&mapping, dataset)?;
        let shared = SharedObserver::new(observer);
        let (done, total) = (AtomicUsize::new(0), mapping.sub_models.len());
        let networks = parallel::map(total, spec.threads, |k| {
            let stopped = || LearnError::Stopped { done: done.load(Ordering::Relaxed), total };
            if shared.stopped() {
                return Err(stopped());
            }
            let task = self.task(&states, spec, k)?;
            let mut part = shared.part(&task.name);
            let model = task.train(&mut part, checkpoints)?.ok_or_else(stopped)?;
            done.fetch_add(1, Ordering::Relaxed);
            part.completed();
            Ok(model)
        })?;
        let (networks, beside) = weighed(&states, dataset, spec, self.rule, networks)?;
        Ok(Box::new(SubModelNetworks::new(&self.name, mapping, networks)?.beside(beside)))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        Ok(Box::new(SubModelNetworks::from_content(&self.name, &columns, content)?))
    }
}
