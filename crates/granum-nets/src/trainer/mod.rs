//! Trainers behind one trait, one file each.

mod levenberg_marquardt;
mod traingdx;
mod training_history;

use granum_simd::Isa;
use serde::{Deserialize, Serialize};

use crate::data::Data;
use crate::network::Network;

pub use levenberg_marquardt::{LevenbergMarquardt, Regularisation};
pub use traingdx::Traingdx;
pub use training_history::{HistoryPoint, TrainerState};

/// Names that [`by_name`] knows, the default first.
pub const NAMES: [&str; 2] = [LevenbergMarquardt::NAME, Traingdx::NAME];

/// What every trainer can be told. A field left `None` takes the trainer's own default.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Options {
    /// Most epochs.
    pub epochs: Option<u64>,
    /// Training ends when the mean squared error (scaled units) is at or below this.
    pub goal: Option<f64>,
    /// Training ends when the Euclidean norm of the gradient of the trainer's objective is at or below this.
    pub minimum_gradient: Option<f64>,
    /// Training with validation rows ends when their error has not fallen for so many accepted steps in a row.
    pub maximum_failures: Option<u64>,
    /// Where Bayesian regularisation starts, see [`LevenbergMarquardt::first_ratio`].
    pub first_ratio: Option<f64>,
    /// The instruction set; the widest of the machine if none. The bits are the same on each.
    pub isa: Option<Isa>,
}

/// Why a trainer cannot be made or cannot train.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// No trainer has this name.
    #[error("there is no trainer \"{0}\"; known are {names}", names = NAMES.join(", "))]
    UnknownTrainer(String),
    /// An option is out of bounds.
    #[error("trainer option {name} = {value}: {expected}")]
    Option {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        expected: &'static str,
    },
    /// The data do not fit the network.
    #[error("the network has {inputs} inputs and {outputs} outputs, the data {columns} and {targets}")]
    Columns {
        /// Inputs of the network.
        inputs: usize,
        /// Outputs of the network.
        outputs: usize,
        /// Input columns of the data.
        columns: usize,
        /// Target columns of the data.
        targets: usize,
    },
    /// The training would need too much memory.
    #[error(
        "{trainer} with {rows} rows and {weights} weights would need {bytes} bytes of memory, more than {limit}; use traingdx, fewer rows or fewer neurons"
    )]
    Memory {
        /// The trainer.
        trainer: &'static str,
        /// Rows.
        rows: usize,
        /// Weights.
        weights: usize,
        /// Estimate.
        bytes: usize,
        /// Limit.
        limit: usize,
    },
    /// A state to go on from belongs to another trainer or network.
    #[error("cannot go on from this state: {0}")]
    State(String),
    /// The error is not finite at the very start.
    #[error("the error of the initial network is {0}: weights or data are too large")]
    NotFinite(f64),
}

/// Why training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum TerminationReason {
    /// The limit of epochs was reached.
    EpochLimit,
    /// The error fell to the goal.
    Goal,
    /// The gradient fell below its limit.
    MinimumGradient,
    /// The error on the validation rows no longer fell.
    ValidationFailures,
    /// No step, however small, lowers the objective.
    MaximumDamping,
    /// Objective and effective number of parameters no longer change.
    Converged,
    /// The observer asked to stop.
    Stopped,
}

impl std::fmt::Display for TerminationReason {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            TerminationReason::EpochLimit => "the limit of epochs was reached",
            TerminationReason::Goal => "the error fell to the goal",
            TerminationReason::MinimumGradient => "the gradient fell below its limit",
            TerminationReason::ValidationFailures => "the error on the validation rows no longer fell",
            TerminationReason::MaximumDamping => "no step, however small, lowers the objective any more",
            TerminationReason::Converged => "objective and effective number of parameters no longer change",
            TerminationReason::Stopped => "stopped on request",
        })
    }
}

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Stop after this epoch: the network keeps the weights it has, and the report holds the state to go on from.
    Stop,
}

/// Where training stands.
pub struct Progress<'a> {
    /// Epochs done (for `traingdx` rejected steps count, as in the toolbox).
    pub epoch: u64,
    /// Most epochs that will be done.
    pub epochs: u64,
    /// Mean squared error over the training rows, in scaled units.
    pub error: f64,
    /// The same over the validation rows, where there are any.
    pub validation_error: Option<f64>,
    pub(crate) state: &'a dyn Fn() -> TrainerState,
}

impl Progress<'_> {
    /// Everything needed to go on from here with identical bits, see [`Trainer::resume`].
    pub fn state(&self) -> TrainerState {
        (self.state)()
    }
}

/// Hears of the progress after every epoch. What it does cannot change the result, except by stopping.
pub trait Observer {
    /// Called after every epoch.
    fn progress(&mut self, progress: &Progress) -> Control;
}

/// An observer that looks away.
pub struct Silent;

impl Observer for Silent {
    fn progress(&mut self, _: &Progress) -> Control {
        Control::Continue
    }
}

impl<F: FnMut(&Progress) -> Control> Observer for F {
    fn progress(&mut self, progress: &Progress) -> Control {
        self(progress)
    }
}

/// What Bayesian regularisation found (MacKay 1992; Foresee and Hagan 1997), in scaled units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// Precision of the weights: `1 / alpha` is their prior variance.
    pub alpha: f64,
    /// Precision of the targets: `1 / beta` is the variance of the noise.
    pub beta: f64,
    /// Effective number of parameters.
    pub gamma: f64,
}

/// What a training did.
#[derive(Clone, Debug)]
pub struct TrainingReport {
    /// Name of the trainer.
    pub trainer: &'static str,
    /// Epochs done.
    pub epochs: u64,
    /// Mean squared error over the training rows in scaled units, at the end.
    pub error: f64,
    /// Mean squared error over the validation rows in scaled units, at the end.
    pub validation_error: Option<f64>,
    /// The history of the error, thinned to at most 1024 points.
    pub history: Vec<HistoryPoint>,
    /// Why it ended.
    pub termination: TerminationReason,
    /// What Bayesian regularisation found, where the trainer does that.
    pub evidence: Option<Evidence>,
    /// Errors (answer less target, in scaled units) that the observations of each block would have if the block had not been
    /// trained on, to first order; where the trainer does that and there are two blocks or more.
    pub left_out: Option<Vec<f64>>,
    /// Wall time. No part of what may be hashed.
    pub seconds: f64,
    /// From here training can go on, see [`Trainer::resume`].
    pub state: TrainerState,
}

/// A way to train a network.
pub trait Trainer: Send + Sync {
    /// Its name in commands and records.
    fn name(&self) -> &'static str;

    /// Trains from the given state, or from the network's weights if there is none. The data are in the network's own
    /// (scaled) units. A resumed training ends with the bits of one that was never interrupted.
    ///
    /// # Errors
    /// If data or state do not fit, or memory would not do.
    fn resume(
        &self,
        network: &mut Network,
        data: &Data,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError>;

    /// Trains from the network's present weights.
    ///
    /// # Errors
    /// As [`Trainer::resume`].
    fn train(
        &self,
        network: &mut Network,
        data: &Data,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError> {
        self.resume(network, data, None, observer)
    }
}

/// The trainer of that name, see [`NAMES`].
///
/// # Errors
/// If there is none, or an option is out of bounds.
pub fn by_name(name: &str, options: &Options) -> Result<Box<dyn Trainer>, TrainingError> {
    check("goal", options.goal, "a number that is zero or positive")?;
    check("first_ratio", options.first_ratio, "a number that is zero or positive")?;
    check("minimum_gradient", options.minimum_gradient, "a number that is zero or positive")?;
    match name {
        LevenbergMarquardt::NAME => Ok(Box::new(LevenbergMarquardt::with_options(options))),
        Traingdx::NAME => Ok(Box::new(Traingdx::with_options(options))),
        _ => Err(TrainingError::UnknownTrainer(name.to_string())),
    }
}

fn check(name: &'static str, value: Option<f64>, expected: &'static str) -> Result<(), TrainingError> {
    match value {
        Some(value) if !(value >= 0.0 && value.is_finite()) => {
            Err(TrainingError::Option { name, value, expected })
        }
        _ => Ok(()),
    }
}

/// Refuses data whose columns are not those of the network.
fn check_columns(network: &Network, data: &Data) -> Result<(), TrainingError> {
    if (network.inputs(), network.outputs()) == (data.input_columns(), data.target_columns()) {
        return Ok(());
    }
    Err(TrainingError::Columns {
        inputs: network.inputs(),
        outputs: network.outputs(),
        columns: data.input_columns(),
        targets: data.target_columns(),
    })
}

#[cfg(test)]
mod tests;
