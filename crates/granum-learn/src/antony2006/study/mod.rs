//! Trains every sub-model of every mapping, each beside a network of the same size that sees strain only, and scores them.

mod evaluation;
mod training;

use granum_nets::Model;
use granum_nets::trainer::{SharedTrainer, TrainerState};

use crate::antony2006::baseline::Baselines;
use crate::antony2006::mapping::{Form, Mapping, paper_mappings};
use crate::antony2006::mapping_networks::MappingNetworks;
use crate::antony2006::study_data::{Run, StudyData};
use crate::dataset::NamedRecord;
use crate::error::{LearnError, Result};

pub(crate) use evaluation::scatter;
pub use evaluation::{Evaluation, Parts, RunScore};
pub(crate) use training::{Job, network_seed, train_all};

/// Fewest training states of a sub-model.
pub const FEWEST_STATES: usize = 3;
/// The trainer whose epochs are those of the tables; others end by their own rule.
pub(crate) const PAPER_TRAINER: &str = "traingdx";

/// What to train, and how.
///
/// ```
/// use granum_learn::StudyOptions;
/// use granum_nets::trainer::LevenbergMarquardt;
///
/// // Any trainer will do, one of a program's own too.
/// let trainer = LevenbergMarquardt { epochs: 100, ..Default::default() };
/// let options = StudyOptions { trainer: trainer.into(), ..StudyOptions::default() };
/// assert_eq!((options.trainer.name(), options.mappings.len()), ("levenberg-marquardt", 6));
/// ```
#[derive(Clone, Debug)]
pub struct StudyOptions {
    /// The mappings.
    pub mappings: Vec<Mapping>,
    /// How the force distribution enters.
    pub form: Form,
    /// The trainer, one of a program's own too. A network has its own first regularisation and, with the paper's trainer, its
    /// own epochs; the trainer is asked to take them by [`granum_nets::trainer::Trainer::adapted`].
    pub trainer: SharedTrainer,
    /// Factor on the epochs of the tables, for the paper's trainer `traingdx`; others end by their own rule.
    pub epoch_factor: f64,
    /// Seed of the study; every network has its own, derived from it and its name.
    pub seed: u64,
    /// Threads, one network each; 0 for as many as the machine has. The result does not depend on it.
    pub threads: usize,
}

impl Default for StudyOptions {
    fn default() -> Self {
        StudyOptions {
            mappings: paper_mappings(),
            form: Form::Point,
            trainer: SharedTrainer::default(),
            epoch_factor: 1.0,
            seed: 1,
            threads: 0,
        }
    }
}

/// Where a study stands, told from the thread that trains.
#[derive(Clone, Copy, Debug)]
pub struct StudyProgress<'a> {
    /// Name of the network: `F1-2`, or `F1-strain-only-2` for the one that sees strain only.
    pub network: &'a str,
    /// Epochs done.
    pub epoch: u64,
    /// Most epochs that will be done.
    pub epochs: u64,
    /// Mean squared error, in scaled units.
    pub error: f64,
}

/// Hears of a study, keeps its networks as they come, and may end it. Every method has a default that does nothing.
///
/// ```
/// use std::sync::atomic::{AtomicUsize, Ordering};
///
/// use granum_learn::StudyObserver;
///
/// /// Counts the networks, and ends the study after the third.
/// #[derive(Default)]
/// struct Three(AtomicUsize);
///
/// impl StudyObserver for Three {
///     fn trained(&self, _network: &str, _model: &granum_nets::Model, _seconds: f64) {
///         self.0.fetch_add(1, Ordering::Relaxed);
///     }
///     fn stop(&self) -> bool {
///         self.0.load(Ordering::Relaxed) >= 3
///     }
/// }
/// assert!(!Three::default().stop());
/// ```
pub trait StudyObserver: Sync {
    /// Called after every epoch of every network.
    fn progress(&self, _progress: &StudyProgress) {}
    /// Called when a network is trained, with the seconds that took, or was found finished (0).
    fn trained(&self, _network: &str, _model: &Model, _seconds: f64) {}
    /// Called after every epoch with what is needed to go on from here, for a training that is told by `key`. `last` is
    /// true if the training ends here because [`StudyObserver::stop`] asks for it.
    fn under_way(&self, _network: &str, _key: &str, _last: bool, _state: &dyn Fn() -> TrainerState) {}
    /// The state of an unfinished training that is told by `key`, to go on from.
    fn state(&self, _network: &str, _key: &str) -> Option<TrainerState> {
        None
    }
    /// A network of an earlier, unfinished study. It is used if it was trained on the same rows with the same size,
    /// seed, trainer and epochs, and else trained again.
    fn finished(&self, _network: &str) -> Option<Model> {
        None
    }
    /// True to end the study.
    fn stop(&self) -> bool {
        false
    }
}

/// An observer that looks away.
pub struct Silent;

impl StudyObserver for Silent {}

/// A trained study.
///
/// ```
/// use granum_core::{Column, Table};
/// use granum_learn::antony2006::study::{Silent, Study, StudyOptions};
/// use granum_learn::antony2006::{StudyData, StudyDataOptions};
/// use granum_learn::dataset::{ColumnGroup, RunStates};
/// use granum_learn::paper_mappings;
///
/// // Two runs as tables: strain rises, the stress ratio follows the fabric, and P(f) has two bins.
/// let run = |name: &str, shift: f64| -> Result<RunStates, Box<dyn std::error::Error>> {
///     let strain: Vec<f64> = (0..=60).map(|k| 0.005 * f64::from(k)).collect();
///     let fabric: Vec<f64> = strain.iter().map(|e| 0.1 * (1.0 - (-40.0 * e).exp()) + shift).collect();
///     let ratio = fabric.iter().map(|f| 6.0 * f).collect();
///     let table = Table::new(vec![
///         Column::new("deviator_strain", "1", strain.clone()),
///         Column::new("stress_ratio", "1", ratio),
///         Column::new("deviator_fabric", "1", fabric),
///         Column::new("probability_density_0.5", "1", strain.iter().map(|e| 0.6 - 0.1 * e).collect()),
///         Column::new("probability_density_1.5", "1", strain.iter().map(|e| 0.3 + 0.1 * e).collect()),
///     ])?;
///     let (name_of, binned) = ("probability_density".to_string(), "force".to_string());
///     let bins = ColumnGroup { name: name_of, binned, bin_width: 1.0, centres: vec![0.5, 1.5] };
///     Ok(RunStates::new(name, table)?.with_group(bins)?)
/// };
/// let data = StudyData::of(&[run("a", 0.0)?, run("b", 0.004)?], &[run("c", 0.002)?], &StudyDataOptions::default())?;
///
/// // The third mapping, q/p = F3(eps_d, phi_d, P(f)), with small networks.
/// let options = StudyOptions { mappings: vec![paper_mappings()[2].with_neurons(3)], ..StudyOptions::default() };
/// let study = Study::train(&data, &options, &Silent)?;
/// let evaluation = &study.evaluate(&data)?[0];
/// assert!(evaluation.network.unseen.relative_rmse < 0.05, "{:?}", evaluation.network.unseen);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Study {
    /// How the force distribution enters.
    pub form: Form,
    /// Trainer.
    pub trainer: String,
    /// Seed of the study.
    pub seed: u64,
    /// Hash of the data set, see [`StudyData::hash`].
    pub dataset_hash: String,
    /// Centres of the bins of f.
    pub forces: Vec<f64>,
    /// Width of a bin.
    pub bin_width: f64,
    /// The mappings, each with its strain-only networks.
    pub mappings: Vec<TrainedMapping>,
    /// What stands beside the networks; `None` of a study that was saved before they were kept.
    pub baselines: Option<Baselines>,
}

/// A mapping, trained.
#[derive(Clone, Debug)]
pub struct TrainedMapping {
    /// The networks.
    pub surrogate: MappingNetworks,
    /// Networks of the same sizes that see strain only.
    pub strain_only: MappingNetworks,
    /// Seconds of training of each network of `surrogate`; 0 for one that was found finished.
    pub seconds: Vec<f64>,
    /// The same for `strain_only`.
    pub strain_only_seconds: Vec<f64>,
}

/// Name of the network of a sub-model.
pub fn network_name(mapping: &Mapping, strain_only: bool, sub_model: usize) -> String {
    let mark = if strain_only { "-strain-only" } else { "" };
    format!("{}{mark}-{}", mapping.name, sub_model + 1)
}

impl Study {
    /// Trains all networks, independent ones side by side.
    ///
    /// # Errors
    /// If a sub-model has too few training states, the trainer refuses, or the observer ends it.
    pub fn train(dataset: &StudyData, options: &StudyOptions, observer: &dyn StudyObserver) -> Result<Study> {
        let alone: Vec<Mapping> = options.mappings.iter().map(Mapping::strain_only).collect();
        let mut jobs = Vec::new();
        for (mappings, strain_only) in [(&options.mappings, false), (&alone, true)] {
            for mapping in mappings {
                for sub_model in 0..mapping.sub_models.len() {
                    let name = network_name(mapping, strain_only, sub_model);
                    let seed = network_seed(options.seed, &name);
                    jobs.push(Job { name, mapping, sub_model, seed });
                }
            }
        }
        let trained = train_all(dataset, &jobs, options, observer)?;
        let mut trained = trained.into_iter();
        let mut collect = |mappings: &[Mapping]| -> Result<Vec<(MappingNetworks, Vec<f64>)>> {
            mappings.iter().map(|mapping| gather(mapping, options.form, dataset, &mut trained)).collect()
        };
        let surrogates = collect(&options.mappings)?;
        let strain_only = collect(&alone)?;
        let mappings = surrogates.into_iter().zip(strain_only).map(|(own, alone)| TrainedMapping {
            surrogate: own.0,
            seconds: own.1,
            strain_only: alone.0,
            strain_only_seconds: alone.1,
        });
        Ok(Study {
            form: options.form,
            trainer: options.trainer.name().to_owned(),
            seed: options.seed,
            dataset_hash: dataset.hash()?,
            forces: dataset.forces.clone(),
            bin_width: dataset.bin_width,
            mappings: mappings.collect(),
            baselines: Some(Baselines::fit(&options.mappings, dataset)?),
        })
    }

    /// The mapping of that name.
    ///
    /// # Errors
    /// [`LearnError::Unknown`].
    pub fn mapping(&self, name: &str) -> Result<&TrainedMapping> {
        let names = || self.mappings.iter().map(|m| m.surrogate.mapping().name.as_str()).collect::<Vec<_>>();
        self.mappings.iter().find(|m| m.surrogate.mapping().name == name).ok_or_else(|| LearnError::Unknown {
            kind: "mapping",
            name: name.to_owned(),
            known: names().join(", "),
        })
    }

    /// Draws from any record the states that the networks can answer.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn read(&self, record: &NamedRecord) -> Result<Run> {
        Run::new(record, &self.forces, self.bin_width)
    }

    /// Seconds of training of all networks that answer (strain-only networks left out).
    pub fn training_seconds(&self) -> f64 {
        self.mappings.iter().flat_map(|mapping| &mapping.seconds).sum()
    }
}

/// The next networks of an iterator as the surrogate of a mapping.
fn gather(
    mapping: &Mapping,
    form: Form,
    dataset: &StudyData,
    trained: &mut impl Iterator<Item = (Model, f64)>,
) -> Result<(MappingNetworks, Vec<f64>)> {
    let (models, seconds) = trained.take(mapping.sub_models.len()).unzip();
    Ok((MappingNetworks::new(mapping.clone(), form, dataset.forces.clone(), models)?, seconds))
}
