//! The errors of trainers, and the reasons why a training ended.

use serde::{Deserialize, Serialize};

/// The reason why a trainer cannot be created or cannot train.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// No trainer has this name.
    #[error("there is no trainer \"{name}\"; there are: {known}")]
    UnknownTrainer {
        /// The name.
        name: String,
        /// The names of the registry.
        known: String,
    },
    /// An option is out of bounds.
    #[error("trainer option {name} = {value}: {expected}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Value of the option.
        value: f64,
        /// Description of valid values.
        expected: &'static str,
    },
    /// The trainer needs more from a model than it provides.
    #[error("{trainer} cannot train a {model}, which provides no Gauss-Newton matrix; use one of: {others}")]
    NoGaussNewton {
        /// Name of the trainer.
        trainer: &'static str,
        /// Kind of the model.
        model: String,
        /// Names of other trainers.
        others: &'static str,
    },
    /// The rows, or their division into sequences, do not match the model.
    #[error("{0}")]
    Rows(String),
    /// The columns of the data do not match the network.
    #[error("the network has {inputs} inputs and {outputs} outputs, the data {columns} and {targets}")]
    Columns {
        /// Number of inputs of the network.
        inputs: usize,
        /// Number of outputs of the network.
        outputs: usize,
        /// Number of input columns of the data.
        columns: usize,
        /// Number of target columns of the data.
        targets: usize,
    },
    /// The number of weights is not that of the network.
    #[error("the network has {expected} weights, not {found}")]
    Weights {
        /// Number of weights of the network.
        expected: usize,
        /// Number of given weights.
        found: usize,
    },
    /// The training would need too much memory.
    #[error(
        "training with {rows} rows and {weights} weights would need {bytes} bytes of memory, more than {limit}; train with adam, which takes a few rows at a time, or use fewer rows or fewer neurons"
    )]
    Memory {
        /// Number of rows.
        rows: usize,
        /// Number of weights.
        weights: usize,
        /// Estimate of the memory, bytes.
        bytes: usize,
        /// Limit of the memory, bytes.
        limit: usize,
    },
    /// The state to resume from belongs to another trainer or network.
    #[error("cannot continue from this state: {0}")]
    State(String),
    /// The error of the initial network is not finite.
    #[error("the error of the initial network is {0}: weights or data are too large")]
    NotFinite(f64),
    /// A user-defined trainer failed.
    #[error("{0}")]
    Own(String),
}

/// The reason why training ended.
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
            TerminationReason::ValidationFailures => "the error on the validation rows no longer decreased",
            TerminationReason::MaximumDamping => "no step, however small, reduces the objective",
            TerminationReason::Converged => "objective and effective number of parameters no longer change",
            TerminationReason::Stopped => "stopped on request",
        })
    }
}
