//! Why a trainer cannot be made or cannot train, and why a training ended.

use serde::{Deserialize, Serialize};

use super::registry::NAMES;

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
    /// There are not as many weights as the network has.
    #[error("the network has {expected} weights, not {found}")]
    Weights {
        /// Weights of the network.
        expected: usize,
        /// Weights that were given.
        found: usize,
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
    /// A trainer from outside failed for a reason of its own.
    #[error("{0}")]
    Own(String),
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
