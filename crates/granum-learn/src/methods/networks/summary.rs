//! The scores of the network of each sub-model.

use serde::{Deserialize, Serialize};

use super::fitted::SubModelNetworks;
use crate::comparison::score_where;
use crate::dataset::{Dataset, SplitParts};
use crate::error::Result;
use crate::score::Score;
use crate::surrogate::{RunInputs, Surrogate};

use crate::surrogate::sub_model::is_within;

/// A network is considered constant if the standard deviation of its predictions is below this fraction of that of the
/// targets.
const CONSTANT: f64 = 1e-3;

/// The network of a sub-model, with its scores in the range of the sub-model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NetworkScores {
    /// Range of the coordinate.
    pub range: [f64; 2],
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
    /// Effective number of parameters, if the trainer determines it.
    pub effective_parameters: Option<f64>,
    /// True if its predictions for all training states in its range are nearly equal, so that it has learned nothing.
    pub constant: bool,
    /// Score on held-out states in its range.
    pub held_out: Score,
    /// Score on unseen runs in its range.
    pub unseen: Score,
}

impl SubModelNetworks {
    /// The scores of every network on the parts of a data set.
    ///
    /// # Errors
    /// If a column is missing or a state cannot be predicted.
    pub fn scores(&self, parts: &SplitParts) -> Result<Vec<NetworkScores>> {
        (0..self.networks().len()).map(|k| self.scores_of(parts, k)).collect()
    }

    fn scores_of(&self, parts: &SplitParts, k: usize) -> Result<NetworkScores> {
        let model = &self.networks()[k];
        let provenance = model.provenance();
        let score = |part: &Dataset| score_where(self, part, &self.in_range(part, k)?);
        Ok(NetworkScores {
            range: self.mapping().sub_models[k].range,
            hidden: self.mapping().sub_models[k].hidden.clone(),
            epochs: provenance.epochs,
            trainer: provenance.trainer.clone(),
            rows: provenance.rows,
            termination: provenance.termination.to_string(),
            effective_parameters: model.training_fit().evidence.map(|evidence| evidence.gamma),
            constant: self.is_constant(&parts.training, k)?,
            held_out: score(&parts.held_out)?,
            unseen: score(&parts.unseen)?,
        })
    }

    /// For each state of a data set whether it is in the range of a sub-model.
    fn in_range(&self, dataset: &Dataset, sub_model: usize) -> Result<Vec<bool>> {
        let mapping = self.mapping();
        if dataset.rows() == 0 {
            return Ok(Vec::new());
        }
        let xs = dataset.column(mapping.coordinate_name())?;
        Ok(xs.iter().map(|x| is_within(&mapping.sub_models, *x, Some(sub_model))).collect())
    }

    /// True if the predictions of a sub-model for the training states in its range are nearly constant: their standard
    /// deviation is below 1e-3 of that of the targets.
    ///
    /// # Errors
    /// If a state contains a value that is not finite.
    pub fn is_constant(&self, training: &Dataset, sub_model: usize) -> Result<bool> {
        let own = self.in_range(training, sub_model)?;
        let predictions = self.means(&RunInputs::from_dataset(training, self.columns())?)?;
        let outputs = training.values(&self.columns().output_names())?;
        let exact = outputs.chunks_exact(self.columns().outputs.len());
        let (mut given, mut targets) = (Vec::new(), Vec::new());
        for ((prediction, exact), _) in predictions.iter().zip(exact).zip(&own).filter(|(_, own)| **own) {
            given.extend_from_slice(prediction);
            targets.extend_from_slice(exact);
        }
        Ok(spread(&given) < CONSTANT * spread(&targets))
    }
}

fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / values.len() as f64).sqrt()
}
