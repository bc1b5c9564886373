//! The summary of a network of a study.

use serde::{Deserialize, Serialize};

use granum_learn::score::Score;

/// One network.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SubModelSummary {
    /// Range of deviator strain.
    pub strain_range: [f64; 2],
    /// Numbers of neurons of the hidden layers.
    pub hidden: Vec<usize>,
    /// Number of epochs of the training.
    pub epochs: u64,
    /// Name of the trainer.
    pub trainer: String,
    /// Number of training rows.
    pub rows: usize,
    /// Reason why the training ended.
    pub termination: String,
    /// Wall time of the training, s; in the file `seconds.json` of the networks.
    #[serde(default, skip_serializing)]
    pub seconds: f64,
    /// Effective number of parameters, if the trainer determines it.
    pub effective_parameters: Option<f64>,
    /// True if its predictions for all training states in its range are nearly equal, so that it has learned nothing.
    #[serde(default)]
    pub constant: bool,
    /// Score on held-out states in its range.
    pub held_out: Score,
    /// Score on unseen runs in its range.
    pub unseen: Score,
}
