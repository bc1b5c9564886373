//! The origin of a model, and the quality of its fit to the training rows.

use serde::{Deserialize, Serialize};

use crate::model::intervals::Intervals;
use crate::table::data::Data;
use crate::trainer::report::{Evidence, TrainingReport};
use crate::training_error::TerminationReason;

/// The origin of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of granum that trained it.
    pub granum_version: String,
    /// Hash of the training rows, see `Data::hash`.
    pub dataset_hash: String,
    /// Number of training rows.
    pub rows: usize,
    /// Seed of the initial weights.
    pub seed: u64,
    /// Name of the trainer.
    pub trainer: String,
    /// Number of epochs of the training.
    pub epochs: u64,
    /// Reason why the training ended.
    pub termination: TerminationReason,
}

impl Provenance {
    /// The origin of a model that this version has trained on these rows.
    pub(crate) fn new(data: &Data, seed: u64, report: &TrainingReport) -> Provenance {
        Provenance {
            granum_version: env!("CARGO_PKG_VERSION").into(),
            dataset_hash: data.hash(),
            rows: data.rows(),
            seed,
            trainer: report.trainer.clone(),
            epochs: report.epochs,
            termination: report.termination,
        }
    }
}

/// The quality of the fit of a model to its training rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Root mean square error over the training rows, in the unit of the output.
    pub rms_error: f64,
    /// Root mean square error over the validation rows, if there were any.
    pub validation_rms_error: Option<f64>,
    /// Standard deviation of the noise in the targets, estimated by Bayesian regularisation, in the unit of the output.
    pub noise: Option<f64>,
    /// The result of Bayesian regularisation, in scaled units.
    pub evidence: Option<Evidence>,
    /// Smallest and largest prediction for the training observations, in the unit of the output.
    #[serde(default)]
    pub answer_range: Option<[f64; 2]>,
    /// Factors on the standard deviations of the Laplace approximation for new blocks (runs), if there were several blocks.
    #[serde(default)]
    pub intervals: Option<Intervals>,
}
