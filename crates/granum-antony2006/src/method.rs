//! The networks of a mapping of the paper as a method of fitting surrogates.

use std::sync::Arc;

use granum_core::observer::Observer;
use granum_learn::dataset::{Dataset, Variable};
use granum_learn::networks::{
    Form, MappingBins, NetworkCheckpoints, NetworkMapping, NetworkSettings, NetworksBySubModel,
    NoCheckpoints, SubModel, SubModelNetworks, training_rows::Rule,
};
use granum_learn::surrogate::{Columns, Content, FitSpec, Surrogate, SurrogateMethod};
use granum_learn::{LearnError, Result};
use granum_nets::Model;
use granum_nets::trainer::SharedTrainer;
use serde::Deserialize;

use crate::data::{PaperDataOptions, check_run, learned_bins};
use crate::mapping::{Mapping, PaperQuantity, paper_mappings};

/// Name of the method.
pub const NAME: &str = "antony2006";
/// The trainer with the numbers of epochs of the tables; other trainers have their own stopping rule.
pub const PAPER_TRAINER: &str = "traingdx";

/// The networks of a mapping of Antony, Zhou and Wang (2006), each for a range of the deviator strain: the general networks by
/// sub-model with the shapes of the tables. With the trainer of the paper a network learns only from the states in its range, for
/// the number of epochs of the tables.
///
/// ```
/// use granum_antony2006::{MappingMethod, paper_mappings};
/// use granum_learn::SurrogateMethod;
///
/// // By default the mapping of the paper with the requested columns is used; here a mapping is given.
/// let mut method = MappingMethod::default();
/// method.mapping = Some(paper_mappings()[2].with_neurons(5));
/// assert_eq!(method.name(), "antony2006");
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MappingMethod {
    /// The mapping for a fit without sub-models; `None` for the one of the paper with the requested inputs and outputs.
    pub mapping: Option<Mapping>,
    /// Form in which the force distribution enters the networks.
    pub form: Form,
    /// The trainer.
    pub trainer: SharedTrainer,
    /// Factor on the numbers of epochs in the tables of the paper, for the trainer of the paper.
    pub epoch_factor: f64,
}

impl Default for MappingMethod {
    fn default() -> Self {
        MappingMethod {
            mapping: None,
            form: Form::Point,
            trainer: SharedTrainer::default(),
            epoch_factor: 1.0,
        }
    }
}

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

impl MappingMethod {
    /// The method for a given mapping.
    pub fn new(mapping: Mapping) -> MappingMethod {
        MappingMethod { mapping: Some(mapping), ..MappingMethod::default() }
    }

    fn networks(&self) -> NetworksBySubModel {
        let of_paper = self.trainer.name() == PAPER_TRAINER;
        let mut method = NetworksBySubModel::default();
        method.name = NAME.into();
        method.coordinate_only_mark = "strain-only".into();
        method.form = self.form;
        method.trainer = self.trainer.clone();
        method.rule = if of_paper { Rule::Separate } else { Rule::Pooled };
        method.epoch_factor = of_paper.then_some(self.epoch_factor);
        method
    }

    /// The states to learn from and the fit with its sub-models: those of the paper, if the fit has none.
    fn completed(&self, dataset: &Dataset, spec: &FitSpec) -> Result<(Dataset, FitSpec)> {
        let Some(first) = dataset.runs().first().filter(|_| spec.sub_models.is_empty()) else {
            return Ok((dataset.clone(), spec.clone()));
        };
        let bins = learned_bins(first, &PaperDataOptions::default())?;
        dataset.runs().iter().try_for_each(|run| check_run(run, &bins))?;
        let mapping = self.chosen(spec, dataset, &bins)?;
        let states =
            dataset.select(|run, row| run.table().values("state").is_none_or(|states| states[row] > 0.0));
        let mut own = mapping.fit(&bins).with_seed(spec.seed).with_threads(spec.threads);
        own.kept_as = spec.kept_as.clone();
        Ok((states, own))
    }

    fn chosen(&self, spec: &FitSpec, dataset: &Dataset, bins: &MappingBins) -> Result<Mapping> {
        let columns = spec.columns(dataset)?;
        let names = |variables: &[Variable]| variables.iter().map(|v| v.name.clone()).collect::<Vec<_>>();
        let (inputs, outputs) = (names(&columns.inputs), names(&columns.outputs));
        let fits = |mapping: &&Mapping| {
            let own = mapping.fit(bins);
            own.inputs == inputs && own.outputs == outputs
        };
        let known = self.mapping.clone().map_or_else(paper_mappings, |mapping| vec![mapping]);
        known.iter().find(fits).cloned().ok_or_else(|| {
            let formulas: Vec<String> = known.iter().map(Mapping::formula).collect();
            failed(format!(
                "no mapping goes from ({}) to ({}); there are: {}",
                inputs.join(", "),
                outputs.join(", "),
                formulas.join("; ")
            ))
        })
    }
}

impl SurrogateMethod for MappingMethod {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "the networks of a mapping of Antony, Zhou and Wang (2006), one for each range of strain"
    }

    fn with_networks(&self, settings: &NetworkSettings) -> Result<Option<Arc<dyn SurrogateMethod>>> {
        Ok(Some(Arc::new(MappingMethod {
            form: settings.form,
            trainer: settings.trainer()?,
            epoch_factor: settings.epoch_factor.unwrap_or(1.0),
            ..self.clone()
        })))
    }

    fn check(&self, dataset: &Dataset, spec: &FitSpec) -> Result<()> {
        let (states, spec) = self.completed(dataset, spec)?;
        self.networks().check(&states, &spec)
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
        let (states, spec) = self.completed(dataset, spec)?;
        self.networks().fit_resumable(&states, &spec, observer, checkpoints)
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let networks = match content.read::<OldContent>() {
            Ok(old) => old.networks(&columns)?,
            Err(_) => SubModelNetworks::from_content(NAME, &columns, content)?,
        };
        Ok(Box::new(networks))
    }
}

/// A mapping and its networks in a file of an earlier version.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OldContent {
    mapping: OldMapping,
    form: Form,
    forces: Vec<f64>,
    networks: Vec<serde_json::Value>,
}

#[derive(Deserialize)]
struct OldMapping {
    name: String,
    inputs: Vec<PaperQuantity>,
    output: PaperQuantity,
    sub_models: Vec<OldSubModel>,
}

#[derive(Deserialize)]
struct OldSubModel {
    strain_range: [f64; 2],
    hidden: Vec<usize>,
    epochs: u64,
}

impl OldContent {
    fn networks(self, columns: &Columns) -> Result<SubModelNetworks> {
        let width = self.forces.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(1.0);
        let bins = MappingBins { binned: "force".into(), width, centres: self.forces };
        let quantity = |quantity: PaperQuantity| granum_learn::networks::MappingQuantity {
            name: quantity.column().into(),
            unit: String::new(),
            bins: (quantity == PaperQuantity::ForceDistribution).then(|| bins.clone()),
        };
        let sub_model = |old: OldSubModel| SubModel {
            range: old.strain_range,
            hidden: old.hidden,
            epochs: Some(old.epochs),
        };
        let mapping = NetworkMapping {
            name: self.mapping.name,
            inputs: self.mapping.inputs.into_iter().map(quantity).collect(),
            coordinate: 0,
            output: quantity(self.mapping.output),
            form: self.form,
            sub_models: self.mapping.sub_models.into_iter().map(sub_model).collect(),
        };
        let models = self.networks.iter();
        let models = models
            .map(|value| Model::from_value(value, "network").map_err(|error| failed(error.to_string())));
        let networks = SubModelNetworks::new(NAME, mapping, models.collect::<Result<_>>()?)?;
        match Surrogate::columns(&networks) == columns {
            true => Ok(networks),
            false => Err(failed("the columns of the mapping are not those that the file names")),
        }
    }
}
