//! What all trainers keep as they go: epochs, the thinned history, early stopping.

use serde::{Deserialize, Serialize};

use super::{Evidence, TrainingError};
use crate::backprop::Workspace;
use crate::data::Data;
use crate::network::Network;
use granum_simd::Isa;

/// Most points of a history.
const POINTS: usize = 1024;

/// The error after an epoch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistoryPoint {
    /// Epochs done.
    pub epoch: u64,
    /// Mean squared error over the training rows, in scaled units.
    pub error: f64,
    /// The same over the validation rows.
    pub validation_error: Option<f64>,
}

/// Everything a trainer needs to go on with identical bits. It can be serialised with any format that keeps the bits
/// of a double.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainerState {
    pub(super) weights: Vec<f64>,
    pub(super) history: TrainingHistory,
    pub(super) method: Method,
}

/// What is particular to a trainer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) enum Method {
    /// Gradient descent with momentum: the last step and the learning rate.
    Traingdx { step: Vec<f64>, rate: f64 },
    /// Damping, regularisation, and how long nothing has changed.
    LevenbergMarquardt {
        damping: f64,
        evidence: Evidence,
        start: Option<Vec<f64>>,
        ceiling: f64,
        settled: bool,
        quiet: u64,
    },
}

impl TrainerState {
    /// Epochs done.
    pub fn epoch(&self) -> u64 {
        self.history.epoch
    }

    /// Refuses a state of another network.
    pub(super) fn check(&self, network: &Network) -> Result<(), TrainingError> {
        let count = network.weights().len();
        if self.weights.len() != count {
            let text = format!("it has {} weights, the network {count}", self.weights.len());
            return Err(TrainingError::State(text));
        }
        let best = self.history.best.as_ref().map_or(count, |b| b.weights.len());
        let step = match &self.method {
            Method::Traingdx { step, .. } => step.len(),
            Method::LevenbergMarquardt { start, .. } => start.as_ref().map_or(count, Vec::len),
        };
        if best != count || step != count {
            return Err(TrainingError::State("its parts have different lengths".into()));
        }
        if self.weights.iter().any(|w| !w.is_finite()) {
            return Err(TrainingError::State("a weight is not a finite number".into()));
        }
        if self.history.counts().iter().any(|n| *n > MOST) || self.history.every == 0 {
            return Err(TrainingError::State("it counts what no training can have made".into()));
        }
        self.method.check()
    }
}

/// More epochs than any training makes.
const MOST: u64 = 1 << 60;

impl Method {
    /// Refuses numbers with which the search for a step would not end.
    fn check(&self) -> Result<(), TrainingError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let good = match self {
            Method::Traingdx { step, rate } => rate.is_finite() && step.iter().all(|x| x.is_finite()),
            Method::LevenbergMarquardt { damping, evidence, start, ceiling, quiet, .. } => {
                let start = start.as_ref().is_none_or(|start| start.iter().all(|x| x.is_finite()));
                let Evidence { alpha, beta, gamma } = *evidence;
                start
                    && positive(*damping)
                    && alpha >= 0.0
                    && alpha.is_finite()
                    && positive(beta)
                    && gamma.is_finite()
                    && *ceiling > 0.0
                    && *quiet < MOST
            }
        };
        if good {
            Ok(())
        } else {
            Err(TrainingError::State("its damping, rate or evidence is no such number".into()))
        }
    }
}

/// The best weights so far by the validation rows.
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

    /// Notes the error after the present epoch. When the history is full, every second point is dropped.
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

    /// Takes in the validation error after an accepted step.
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

/// The rows for early stopping, laid out.
pub(super) struct Validation {
    workspace: Workspace,
    values: f64,
}

impl Validation {
    pub(super) fn new(isa: Isa, network: &Network, data: &Data) -> Option<Validation> {
        let rows = data.validation()?;
        let values = rows.observations() * rows.target_columns() as f64;
        Some(Validation { workspace: Workspace::new(isa, network, rows), values })
    }

    /// Mean squared error.
    pub(super) fn error(&mut self, weights: &[f64]) -> f64 {
        self.workspace.squared_error(weights) / self.values
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
