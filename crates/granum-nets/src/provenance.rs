//! Where a model comes from, and how well it fits its training rows.

use serde::{Deserialize, Serialize};

use crate::intervals::Intervals;
use crate::trainer::{Evidence, TerminationReason};

/// Where a model comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of granum that trained it.
    pub granum_version: String,
    /// Hash of the rows it was trained on, see [`Data::hash`].
    pub dataset_hash: String,
    /// Number of those rows.
    pub rows: usize,
    /// Seed of the initial weights.
    pub seed: u64,
    /// Name of the trainer.
    pub trainer: String,
    /// Epochs that it took.
    pub epochs: u64,
    /// Why it ended.
    pub termination: TerminationReason,
}

/// How well a model fits the rows it was trained on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Root of the mean squared error over the training rows, in the unit of the output.
    pub rms_error: f64,
    /// The same over the validation rows, if there were any.
    pub validation_rms_error: Option<f64>,
    /// Standard deviation of the noise in the targets as Bayesian regularisation estimates it, in the unit of the
    /// output.
    pub noise: Option<f64>,
    /// What Bayesian regularisation found, in scaled units.
    pub evidence: Option<Evidence>,
    /// Least and largest answer to the training observations, in the unit of the output.
    #[serde(default)]
    pub answer_range: Option<[f64; 2]>,
    /// How much farther than the Laplace approximation says new blocks (runs) are off, where there were several.
    #[serde(default)]
    pub intervals: Option<Intervals>,
}
