//! The state of a trainer: weights, epochs, the thinned history, and named numbers that are specific to the trainer.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::differentiable::{Batch, Differentiable};
use crate::table::data::Data;
use crate::training_error::{TerminationReason, TrainingError};
use granum_simd::Isa;

/// Largest number of points of a history.
const POINTS: usize = 1024;
/// An upper limit of the number of epochs that no training reaches.
pub(crate) const MOST: u64 = 1 << 60;

/// The error after an epoch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistoryPoint {
    /// Number of completed epochs.
    pub epoch: u64,
    /// Mean squared error over the training rows, in scaled units.
    pub error: f64,
    /// Mean squared error over the validation rows.
    pub validation_error: Option<f64>,
}

/// The state from which a trainer can be resumed with bit-identical results: the weights, the history, and the data of the
/// trainer itself as named lists of numbers. It can be serialised in any format that preserves the bits of a double.
///
/// ```
/// use granum_nets::trainer::TrainerState;
///
/// let mut state = TrainerState::new("mine", vec![0.1, 0.2]).with("step", &[0.5, 0.5]);
/// state.note_epoch(&[0.3, 0.4], 1e-3);
/// assert_eq!((state.epoch(), state.weights(), state.history().len()), (1, &[0.3, 0.4][..], 1));
/// assert_eq!(state.vector("step", 2).unwrap(), [0.5, 0.5]);
/// let error = state.number("rate").unwrap_err();
/// assert_eq!(error.to_string(), "cannot continue from this state: it has no \"rate\"");
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainerState {
    trainer: String,
    pub(super) weights: Vec<f64>,
    pub(super) history: TrainingHistory,
    own: BTreeMap<String, Vec<f64>>,
}

impl TrainerState {
    /// The state before the first epoch.
    pub fn new(trainer: &str, weights: Vec<f64>) -> TrainerState {
        TrainerState::with_history(trainer, weights, TrainingHistory::new())
    }

    pub(super) fn with_history(trainer: &str, weights: Vec<f64>, history: TrainingHistory) -> TrainerState {
        TrainerState { trainer: trainer.into(), weights, history, own: BTreeMap::new() }
    }

    /// Adds numbers of the trainer under a name.
    pub fn with(mut self, name: &str, values: &[f64]) -> TrainerState {
        self.set(name, values);
        self
    }

    /// Stores numbers of the trainer under a name.
    pub fn set(&mut self, name: &str, values: &[f64]) {
        self.own.insert(name.into(), values.to_vec());
    }

    /// Counts an epoch, and stores its weights and the mean squared error after it.
    pub fn note_epoch(&mut self, weights: &[f64], error: f64) {
        self.weights = weights.to_vec();
        self.history.epoch += 1;
        self.history.note(error, None);
    }

    /// Name of the trainer to which the state belongs.
    pub fn trainer(&self) -> &str {
        &self.trainer
    }

    /// Number of completed epochs.
    pub fn epoch(&self) -> u64 {
        self.history.epoch
    }

    /// The current weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The history of the error, thinned to at most 1024 points.
    pub fn history(&self) -> &[HistoryPoint] {
        &self.history.history
    }

    /// The numbers that the trainer stored under a name.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.own.get(name).map(Vec::as_slice)
    }

    /// A given number of values that the trainer stored under a name.
    ///
    /// # Errors
    /// [`TrainingError::State`] if they do not exist, are not of that number, or are not finite.
    pub fn vector(&self, name: &str, length: usize) -> Result<&[f64], TrainingError> {
        let refused = |reason: String| Err(TrainingError::State(reason));
        match self.values(name) {
            None => refused(format!("it has no \"{name}\"")),
            Some(values) if values.len() != length => {
                refused(format!("it has {} numbers of \"{name}\", not {length}", values.len()))
            }
            Some(values) if values.iter().any(|x| !x.is_finite()) => {
                refused(format!("a number of \"{name}\" is not finite"))
            }
            Some(values) => Ok(values),
        }
    }

    /// A single number that the trainer stored under a name.
    ///
    /// # Errors
    /// As [`TrainerState::vector`].
    pub fn number(&self, name: &str) -> Result<f64, TrainingError> {
        Ok(self.vector(name, 1)?[0])
    }

    /// Refuses a state of another trainer or model, and an invalid state.
    ///
    /// # Errors
    /// [`TrainingError::State`] with the reason.
    pub fn check(&self, trainer: &str, model: &dyn Differentiable) -> Result<(), TrainingError> {
        let refused = |reason: String| Err(TrainingError::State(reason));
        if self.trainer != trainer {
            return refused(format!("it was written by {}, not by {trainer}", self.trainer));
        }
        let count = model.weights().len();
        if self.weights.len() != count {
            return refused(format!("it has {} weights, the network {count}", self.weights.len()));
        }
        if self.history.best.as_ref().is_some_and(|best| best.weights.len() != count) {
            return refused("its parts have different lengths".into());
        }
        if self.weights.iter().any(|w| !w.is_finite()) {
            return refused("a weight is not a finite number".into());
        }
        if self.history.counts().iter().any(|n| *n > MOST) || self.history.every == 0 {
            return refused("its counters have impossible values".into());
        }
        Ok(())
    }
}

/// The weights with the smallest error on the validation rows so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Best {
    pub error: f64,
    pub weights: Vec<f64>,
}

/// The history of a training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrainingHistory {
    pub epoch: u64,
    every: u64,
    pub history: Vec<HistoryPoint>,
    pub best: Option<Best>,
    pub failures: u64,
}

impl TrainingHistory {
    fn counts(&self) -> [u64; 3] {
        [self.epoch, self.every, self.failures]
    }

    pub(super) fn new() -> TrainingHistory {
        TrainingHistory { epoch: 0, every: 1, history: Vec::new(), best: None, failures: 0 }
    }

    /// Stores the error after the current epoch. When the history is full, every second point is dropped.
    pub(super) fn note(&mut self, error: f64, validation_error: Option<f64>) {
        if !self.epoch.is_multiple_of(self.every) {
            return;
        }
        if self.history.len() >= POINTS {
            self.every *= 2;
            let every = self.every;
            self.history.retain(|p| p.epoch.is_multiple_of(every));
            if !self.epoch.is_multiple_of(every) {
                return;
            }
        }
        self.history.push(HistoryPoint { epoch: self.epoch, error, validation_error });
    }

    /// The weights with the smallest validation error, which a training that ended for the given reason returns instead of its
    /// last weights; `None` if there are no validation rows, or if the training was stopped and can be resumed.
    pub(super) fn best_at(&self, termination: TerminationReason) -> Option<&Best> {
        self.best.as_ref().filter(|_| termination != TerminationReason::Stopped)
    }

    /// Processes the validation error after an accepted step.
    pub(super) fn validate(&mut self, error: f64, weights: &[f64]) {
        match &mut self.best {
            Some(best) if error < best.error => {
                best.error = error;
                best.weights.copy_from_slice(weights);
                self.failures = 0;
            }
            Some(_) => self.failures += 1,
            None => self.best = Some(Best { error, weights: weights.to_vec() }),
        }
    }
}

/// The rows for early stopping in the layout for training.
pub(super) struct Validation {
    batch: Box<dyn Batch>,
    values: f64,
}

impl Validation {
    pub(super) fn new(
        isa: Isa,
        model: &dyn Differentiable,
        data: &Data,
    ) -> Result<Option<Validation>, TrainingError> {
        let Some(rows) = data.validation() else { return Ok(None) };
        let values = rows.observations() * rows.target_columns() as f64;
        Ok(Some(Validation { batch: model.batch(isa, rows)?, values }))
    }

    /// Mean squared error over the validation rows.
    pub(super) fn error(&mut self, weights: &[f64]) -> f64 {
        self.batch.squared_error(weights) / self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_history_is_thinned_evenly() {
        let mut history = TrainingHistory::new();
        for epoch in 0..10_000 {
            history.epoch = epoch;
            history.note(1.0 / (1.0 + epoch as f64), None);
        }
        assert!(history.history.len() <= POINTS && history.history.len() >= POINTS / 2);
        assert_eq!(history.history[0].epoch, 0);
        let gaps: Vec<u64> = history.history.windows(2).map(|p| p[1].epoch - p[0].epoch).collect();
        assert!(gaps.iter().all(|&g| g == gaps[0]));
    }
}
