//! The limited-memory method of Broyden, Fletcher, Goldfarb and Shanno over all rows: for networks whose curvature matrix is too large.
//!
//! A step goes along the quasi-Newton direction `-H g`, in which `H` follows from the last steps `s` and changes `y` of the gradient
//! by the two-loop recursion (Liu and Nocedal 1989). Its length is doubled or bisected until the error falls enough and its slope is
//! small enough (the weak conditions of Wolfe), which keeps `s y > 0`. The first step has the length one at most. With validation rows,
//! which should be those of whole runs ([`crate::Data::with_validation_blocks`]), the weights with the smallest error on them are
//! returned.

use granum_core::clock::Instant;
use granum_core::observer::{Flow, Observer};
use granum_simd::Isa;

use super::kind::TrainerKind;
use super::options::Options;
use super::report::TrainingReport;
use super::state::{TrainerState, TrainingHistory, Validation};
use super::trainer_trait::{SharedTrainer, Trainer, training_progress};
use super::traingdx::norm;
use crate::differentiable::check_columns;
use crate::differentiable::{Batch, Differentiable};
use crate::linear_algebra::minimise::{dot, quasi_newton};
use crate::table::data::Data;
use crate::training_error::{TerminationReason, TrainingError};

/// The entry of the registry.
pub(super) const KIND: TrainerKind = TrainerKind {
    name: Lbfgs::NAME,
    help: "limited-memory quasi-Newton steps over all rows, for networks too large for levenberg-marquardt",
    make: |options| Lbfgs::with_options(options).into(),
};

/// Share of the decrease that the gradient promises which a step must reach, and share of the slope that may be left after it.
const WOLFE: [f64; 2] = [1e-4, 0.9];
/// Evaluations of a search along a direction before it ends.
const TRIALS: usize = 30;

/// Limited-memory quasi-Newton steps.
///
/// ```
/// use granum_nets::trainer::{Lbfgs, NoObserver, Trainer};
/// use granum_nets::{Data, Network};
///
/// let x: Vec<f64> = (0..400).map(|k| f64::from(k) / 199.5 - 1.0).collect();
/// let y = x.iter().map(|x| 0.5 + 0.3 * (3.0 * x).sin()).collect();
/// let mut network = Network::new(&[1, 12, 1], 1)?;
/// let trainer = Lbfgs { epochs: 200, ..Lbfgs::default() };
/// let report = trainer.train(&mut network, &Data::new(x, 1, y)?, &mut NoObserver)?;
/// assert!(report.error.sqrt() < 0.01, "{}", report.error.sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Lbfgs {
    /// Largest number of steps, each of which visits all rows once or a few times (1000).
    pub epochs: u64,
    /// Training ends when the mean squared error (scaled units) is at or below this (0).
    pub goal: f64,
    /// Training ends when the norm of the gradient is at or below this (1e-9).
    pub minimum_gradient: f64,
    /// Training with validation rows ends when their error has not fallen for so many steps in a row (100).
    pub maximum_failures: u64,
    /// Number of steps that are remembered (10).
    pub memory: usize,
    /// Instruction set; results do not depend on it.
    pub isa: Isa,
}

impl Default for Lbfgs {
    fn default() -> Self {
        Lbfgs {
            epochs: 1000,
            goal: 0.0,
            minimum_gradient: 1e-9,
            maximum_failures: 100,
            memory: 10,
            isa: Isa::detect(),
        }
    }
}

impl Lbfgs {
    /// Name of the trainer in commands and records.
    pub const NAME: &'static str = "l-bfgs";

    /// The defaults, changed by the options.
    pub fn with_options(options: &Options) -> Lbfgs {
        Lbfgs::default().changed(options)
    }

    fn changed(&self, options: &Options) -> Lbfgs {
        Lbfgs {
            epochs: options.epochs.unwrap_or(self.epochs),
            goal: options.goal.unwrap_or(self.goal),
            minimum_gradient: options.minimum_gradient.unwrap_or(self.minimum_gradient),
            maximum_failures: options.maximum_failures.unwrap_or(self.maximum_failures),
            isa: options.isa.unwrap_or(self.isa),
            ..self.clone()
        }
    }
}

impl Trainer for Lbfgs {
    fn name(&self) -> &str {
        Lbfgs::NAME
    }

    fn adapted(&self, options: &Options) -> Option<SharedTrainer> {
        Some(self.changed(options).into())
    }

    fn resume(
        &self,
        model: &mut dyn Differentiable,
        data: &Data,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError> {
        if self.memory == 0 {
            let expected = "at least one step";
            return Err(TrainingError::Option { name: "memory", value: 0.0, expected });
        }
        check_columns(model, data)?;
        let clock = Instant::now();
        let mut descent = Descent::start(self, model, data, state)?;
        let termination = descent.run(observer);
        let mut validation_error = descent.validation_error;
        let mut error = descent.error;
        model.weights_mut().copy_from_slice(&descent.weights);
        if let Some(best) = descent.history.best_at(termination) {
            model.weights_mut().copy_from_slice(&best.weights);
            validation_error = Some(best.error);
            error = descent.batch.squared_error(&best.weights) / descent.values;
        }
        Ok(TrainingReport {
            validation_error,
            seconds: clock.elapsed().as_secs_f64(),
            ..TrainingReport::new(descent.state(), error, termination)
        })
    }
}

/// The state of a descent.
struct Descent<'a> {
    rule: &'a Lbfgs,
    batch: Box<dyn Batch>,
    /// Number of errors: observations times targets.
    values: f64,
    validation: Option<Validation>,
    weights: Vec<f64>,
    /// Mean squared error and its gradient at the weights.
    error: f64,
    gradient: Vec<f64>,
    /// Steps and changes of the gradient, the oldest first.
    pairs: Vec<(Vec<f64>, Vec<f64>)>,
    validation_error: Option<f64>,
    history: TrainingHistory,
}

const STEPS: &str = "steps";
const CHANGES: &str = "changes_of_gradient";

impl<'a> Descent<'a> {
    fn start(
        rule: &'a Lbfgs,
        model: &dyn Differentiable,
        data: &Data,
        state: Option<TrainerState>,
    ) -> Result<Descent<'a>, TrainingError> {
        let fresh = state.is_none();
        let state = state.unwrap_or_else(|| {
            TrainerState::new(Lbfgs::NAME, model.weights().to_vec()).with(STEPS, &[]).with(CHANGES, &[])
        });
        state.check(Lbfgs::NAME, model)?;
        let count = model.weights().len();
        let length = state.values(STEPS).map_or(0, <[f64]>::len);
        let (steps, changes) = (state.vector(STEPS, length)?, state.vector(CHANGES, length)?);
        let pairs: Vec<(Vec<f64>, Vec<f64>)> = steps
            .chunks(count)
            .zip(changes.chunks(count))
            .map(|(step, change)| (step.to_vec(), change.to_vec()))
            .collect();
        let curved = |(step, change): &(Vec<f64>, Vec<f64>)| dot(step, change) > 0.0;
        if !length.is_multiple_of(count) || pairs.len() > rule.memory || !pairs.iter().all(curved) {
            return Err(TrainingError::State("its steps are not those of a descent".into()));
        }
        let mut descent = Descent {
            rule,
            batch: model.batch(rule.isa, data)?,
            values: data.observations() * data.target_columns() as f64,
            validation: Validation::new(rule.isa, model, data)?,
            error: 0.0,
            gradient: vec![0.0; count],
            pairs,
            validation_error: None,
            weights: state.weights,
            history: state.history,
        };
        let mut gradient = vec![0.0; count];
        descent.error = descent.evaluate(&descent.weights.clone(), &mut gradient);
        if !descent.error.is_finite() {
            return Err(TrainingError::NotFinite(descent.error));
        }
        descent.gradient = gradient;
        descent.validation_error = descent.validation.as_mut().map(|v| v.error(&descent.weights));
        if fresh {
            if let Some(error) = descent.validation_error {
                descent.history.validate(error, &descent.weights);
            }
            descent.history.note(descent.error, descent.validation_error);
        }
        Ok(descent)
    }

    fn state(&self) -> TrainerState {
        let steps: Vec<f64> = self.pairs.iter().flat_map(|(step, _)| step).copied().collect();
        let changes: Vec<f64> = self.pairs.iter().flat_map(|(_, change)| change).copied().collect();
        TrainerState::with_history(Lbfgs::NAME, self.weights.clone(), self.history.clone())
            .with(STEPS, &steps)
            .with(CHANGES, &changes)
    }

    fn evaluate(&mut self, weights: &[f64], gradient: &mut [f64]) -> f64 {
        let error = self.batch.squared_error(weights) / self.values;
        self.batch.gradient(weights, 2.0 / self.values, gradient);
        error
    }

    fn run(&mut self, observer: &mut dyn Observer) -> TerminationReason {
        loop {
            if let Some(reason) = self.finished() {
                return reason;
            }
            if !self.step() {
                return TerminationReason::MaximumDamping;
            }
            let progress =
                training_progress(self.history.epoch, self.rule.epochs, self.error, self.validation_error);
            if observer.progress(&progress) == Flow::Stop {
                return TerminationReason::Stopped;
            }
        }
    }

    fn finished(&self) -> Option<TerminationReason> {
        if self.error <= self.rule.goal {
            Some(TerminationReason::Goal)
        } else if self.history.epoch >= self.rule.epochs {
            Some(TerminationReason::EpochLimit)
        } else if self.validation.is_some() && self.history.failures >= self.rule.maximum_failures {
            Some(TerminationReason::ValidationFailures)
        } else if norm(self.rule.isa, &self.gradient) <= self.rule.minimum_gradient {
            Some(TerminationReason::MinimumGradient)
        } else {
            None
        }
    }

    /// One step; returns false if no step lowers the error.
    fn step(&mut self) -> bool {
        let found = self.search().or_else(|| {
            // The remembered curvature may mislead: the gradient alone is tried before the end.
            self.pairs.clear();
            self.search()
        });
        let Some((weights, error, gradient)) = found else { return false };
        let step: Vec<f64> = weights.iter().zip(&self.weights).map(|(new, old)| new - old).collect();
        let change: Vec<f64> = gradient.iter().zip(&self.gradient).map(|(new, old)| new - old).collect();
        if dot(&step, &change) > 1e-12 * dot(&change, &change) {
            if self.pairs.len() == self.rule.memory {
                self.pairs.remove(0);
            }
            self.pairs.push((step, change));
        }
        (self.weights, self.error, self.gradient) = (weights, error, gradient);
        self.history.epoch += 1;
        if let Some(validation) = &mut self.validation {
            let error = validation.error(&self.weights);
            self.validation_error = Some(error);
            self.history.validate(error, &self.weights);
        }
        self.history.note(self.error, self.validation_error);
        true
    }

    /// Weights, error and gradient along the quasi-Newton direction where the weak conditions of Wolfe hold; if the trials are used
    /// up before, the lowest of those with enough decrease.
    fn search(&mut self) -> Option<(Vec<f64>, f64, Vec<f64>)> {
        let direction = quasi_newton(&self.gradient, &self.pairs);
        let slope = dot(&direction, &self.gradient);
        if slope.is_nan() || slope >= 0.0 {
            return None;
        }
        let (mut low, mut high, mut factor) = (0.0, f64::INFINITY, 1.0);
        let mut best: Option<(Vec<f64>, f64, Vec<f64>)> = None;
        for _ in 0..TRIALS {
            let weights: Vec<f64> =
                self.weights.iter().zip(&direction).map(|(w, d)| w + factor * d).collect();
            let mut gradient = vec![0.0; weights.len()];
            let error = self.evaluate(&weights, &mut gradient);
            let falls = error <= self.error + WOLFE[0] * factor * slope;
            if !falls || gradient.iter().any(|g| !g.is_finite()) {
                high = factor;
            } else {
                let enough = dot(&direction, &gradient) >= WOLFE[1] * slope;
                if best.as_ref().is_none_or(|(_, least, _)| error < *least) {
                    best = Some((weights, error, gradient));
                }
                if enough {
                    break;
                }
                low = factor;
            }
            factor = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * factor };
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed_forward::network::Network;
    use crate::trainer::{NoObserver, Traingdx};

    fn wave() -> Data {
        let x: Vec<f64> = (0..120).map(|k| f64::from(k) / 59.5 - 1.0).collect();
        let y = x.iter().map(|x| 0.5 + 0.3 * (4.0 * x).sin()).collect();
        Data::new(x, 1, y).unwrap()
    }

    #[test]
    fn it_descends_farther_than_gradients_alone() {
        let start = Network::new(&[1, 10, 1], 3).unwrap();
        let error = |trainer: &dyn Trainer| {
            trainer.train(&mut start.clone(), &wave(), &mut NoObserver).unwrap().error
        };
        let ours = error(&Lbfgs { epochs: 150, ..Lbfgs::default() });
        let theirs = error(&Traingdx { epochs: 150, ..Traingdx::default() });
        assert!(ours < 1e-4 && ours < 0.05 * theirs, "{ours} {theirs}");
    }

    #[test]
    fn errors_never_rise_and_whole_runs_stop_it() {
        let blocks = (0..120).map(|k| k / 10).collect();
        let data = wave().with_blocks(blocks).unwrap().with_validation_blocks(&[2, 7]).unwrap();
        let mut network = Network::new(&[1, 30, 1], 3).unwrap();
        let rule = Lbfgs { epochs: 400, maximum_failures: 20, ..Lbfgs::default() };
        let report = rule.train(&mut network, &data, &mut NoObserver).unwrap();
        assert!(report.history.windows(2).all(|pair| pair[1].error <= pair[0].error));
        let least = report.history.iter().filter_map(|p| p.validation_error).fold(f64::INFINITY, f64::min);
        assert_eq!(report.validation_error, Some(least));
        let none = Lbfgs { memory: 0, ..Lbfgs::default() };
        let text = none.train(&mut network, &data, &mut NoObserver).unwrap_err().to_string();
        assert_eq!(text, "trainer option memory = 0: at least one step");
    }
}
