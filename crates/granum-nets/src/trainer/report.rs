//! The report of a training.

use serde::{Deserialize, Serialize};

use super::state::{HistoryPoint, TrainerState};
use crate::training_error::TerminationReason;

/// The result of Bayesian regularisation (MacKay 1992; Foresee and Hagan 1997), in scaled units.
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

/// The report of a training.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TrainingReport {
    /// Name of the trainer.
    pub trainer: String,
    /// Number of epochs.
    pub epochs: u64,
    /// Mean squared error over the training rows in scaled units, at the end.
    pub error: f64,
    /// Mean squared error over the validation rows in scaled units, at the end.
    pub validation_error: Option<f64>,
    /// The history of the error, thinned to at most 1024 points.
    pub history: Vec<HistoryPoint>,
    /// Reason why the training ended.
    pub termination: TerminationReason,
    /// The result of Bayesian regularisation, if the trainer uses it.
    pub evidence: Option<Evidence>,
    /// Errors (output minus target, in scaled units) that the observations of each block would have, to first order, if
    /// the block had not been used for training; available if the trainer computes them and there are two or more blocks.
    pub left_out: Option<Vec<f64>>,
    /// Wall time, s; 0 if the trainer did not measure it. It must not enter a hash of the result.
    pub seconds: f64,
    /// The state from which training can be resumed, see [`super::Trainer::resume`].
    pub state: TrainerState,
}

impl TrainingReport {
    /// The report of a training that ended in a state with the given mean squared error, without the optional parts.
    pub fn new(state: TrainerState, error: f64, termination: TerminationReason) -> TrainingReport {
        TrainingReport {
            trainer: state.trainer().to_string(),
            epochs: state.epoch(),
            error,
            validation_error: None,
            history: state.history().to_vec(),
            termination,
            evidence: None,
            left_out: None,
            seconds: 0.0,
            state,
        }
    }
}
