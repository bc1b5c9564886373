//! The study of the paper as a configuration of a general study.

use granum_learn::networks::{Form, NetworkSettings};
use granum_learn::study::{Study, StudyDefinition, StudyObserver};
use granum_learn::{Result, SurrogateMethods};
use granum_nets::trainer::SharedTrainer;

use crate::data::PaperData;
use crate::mapping::{Mapping, paper_mappings};
use crate::method::{MappingMethod, NAME, PAPER_TRAINER};

/// Options of the study.
///
/// ```
/// use granum_antony2006::PaperOptions;
/// use granum_nets::trainer::LevenbergMarquardt;
///
/// // Any trainer can be used, including a user-defined one.
/// let trainer = LevenbergMarquardt { epochs: 100, ..Default::default() };
/// let options = PaperOptions { trainer: trainer.into(), ..PaperOptions::default() };
/// assert_eq!((options.trainer.name(), options.mappings.len()), ("levenberg-marquardt", 6));
/// ```
#[derive(Clone, Debug)]
pub struct PaperOptions {
    /// The mappings.
    pub mappings: Vec<Mapping>,
    /// Form in which the force distribution enters the networks.
    pub form: Form,
    /// The trainer, which may be defined by the user.
    pub trainer: SharedTrainer,
    /// Factor on the numbers of epochs of the tables, for the trainer `traingdx` of the paper; other trainers have their own
    /// stopping rule.
    pub epoch_factor: f64,
    /// Seed of the study; the seed of every network is derived from it and from the name of the network.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. The result does not depend on it.
    pub threads: usize,
}

impl Default for PaperOptions {
    fn default() -> Self {
        PaperOptions {
            mappings: paper_mappings(),
            form: Form::Point,
            trainer: SharedTrainer::default(),
            epoch_factor: 1.0,
            seed: 1,
            threads: 0,
        }
    }
}

impl PaperOptions {
    /// The options by which a study was trained: its mappings, and the settings of their networks.
    ///
    /// # Errors
    /// If the study is not one of the mappings of the paper, or there is no trainer of its name.
    pub fn from_definition(definition: &StudyDefinition) -> Result<PaperOptions> {
        let (form, epoch_factor) = (definition.networks.form, definition.networks.epoch_factor);
        Ok(PaperOptions {
            mappings: definition.fits.iter().map(Mapping::from_fit).collect::<Result<_>>()?,
            form,
            trainer: definition.networks.trainer()?,
            epoch_factor: epoch_factor.unwrap_or(1.0),
            seed: definition.fits.first().map_or(1, |fit| fit.seed),
            threads: definition.threads,
        })
    }

    /// The study of some data: the mappings as fits, and the networks of the paper as the only method.
    pub fn definition(&self, data: &PaperData) -> StudyDefinition {
        let fit = |mapping: &Mapping| mapping.fit(&data.bins).with_seed(self.seed);
        let mut definition = StudyDefinition::new(self.mappings.iter().map(fit), [NAME], data.split.clone());
        let epoch_factor = (self.trainer.name() == PAPER_TRAINER).then_some(self.epoch_factor);
        let trainer = self.trainer.name().to_owned();
        definition.networks =
            NetworkSettings { trainer, form: self.form, epoch_factor, ..NetworkSettings::default() };
        definition.threads = self.threads;
        definition
    }

    /// The general methods, and the networks of the paper with these options.
    pub fn methods(&self) -> SurrogateMethods {
        let method = MappingMethod {
            mapping: None,
            form: self.form,
            trainer: self.trainer.clone(),
            epoch_factor: self.epoch_factor,
        };
        SurrogateMethods::standard().replaced_by(method)
    }

    /// Trains the study of some data.
    ///
    /// # Errors
    /// As [`Study::train`].
    pub fn train(&self, data: &PaperData, observer: &dyn StudyObserver) -> Result<Study> {
        Study::train(&data.dataset, &self.definition(data), &self.methods(), observer)
    }
}

/// True if a study is one of the mappings of the paper.
pub fn is_of_paper(definition: &StudyDefinition) -> bool {
    definition.methods == [NAME] && definition.fits.iter().all(|fit| fit.name.is_some())
}

/// The files in the folder of a study of the mappings by versions with another format, which a new training replaces.
pub fn files_of_earlier_versions() -> Vec<String> {
    let networks = (1..=6).flat_map(|mapping| {
        let marks = ["", "-strain-only"].into_iter();
        marks.flat_map(move |mark| (1..=3).map(move |k| format!("F{mapping}{mark}-{k}")))
    });
    let files = networks.flat_map(|name| [format!("{name}.json"), format!("{name}.unfinished")]);
    files.chain(["baselines.json".to_string()]).collect()
}
