//! Options of a study.

use granum_nets::trainer::SharedTrainer;

use crate::mapping::{Form, Mapping, paper_mappings};

/// Smallest number of training states of a sub-model.
pub const FEWEST_STATES: usize = 3;
/// The trainer with the numbers of epochs of the tables; other trainers have their own stopping rule.
pub(crate) const PAPER_TRAINER: &str = "traingdx";

/// Options of a study.
///
/// ```
/// use granum_antony2006::StudyOptions;
/// use granum_nets::trainer::LevenbergMarquardt;
///
/// // Any trainer can be used, including a user-defined one.
/// let trainer = LevenbergMarquardt { epochs: 100, ..Default::default() };
/// let options = StudyOptions { trainer: trainer.into(), ..StudyOptions::default() };
/// assert_eq!((options.trainer.name(), options.mappings.len()), ("levenberg-marquardt", 6));
/// ```
#[derive(Clone, Debug)]
pub struct StudyOptions {
    /// The mappings.
    pub mappings: Vec<Mapping>,
    /// Form in which the force distribution enters the networks.
    pub form: Form,
    /// The trainer, which may be defined by the user. The initial regularisation and, with the trainer of the paper, the
    /// number of epochs depend on the network; they are passed to the trainer by
    /// [`granum_nets::trainer::Trainer::adapted`].
    pub trainer: SharedTrainer,
    /// Factor on the numbers of epochs of the tables, for the trainer `traingdx` of the paper; other trainers have their own
    /// stopping rule.
    pub epoch_factor: f64,
    /// Seed of the study; the seed of every network is derived from it and from the name of the network.
    pub seed: u64,
    /// Number of threads, each of which trains one network at a time; 0 for the number of processors. The result does not
    /// depend on it.
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
