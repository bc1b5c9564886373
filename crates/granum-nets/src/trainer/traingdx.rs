//! Batch gradient descent with momentum and an adaptive learning rate: the trainer of Antony, Zhou and Wang (2006).
//!
//! The rule is that of `traingdx` of the MATLAB Neural Network Toolbox. With the mean squared error
//! `E = sum w e^2 / (rows * targets)`, its gradient `g`, momentum `m`, learning rate `r` and the last step `s`:
//!
//! ```text
//! s <- m s - (1 - m) r g          try the weights x + s
//! E(x + s) > 1.04 E(x):  rejected; r <- 0.7 r, and s <- -r g, so that the next step has no momentum
//! otherwise:             accepted; if E(x + s) < E(x), r <- 1.05 r
//! ```
//!
//! An epoch is one such trial, even if it is rejected. With validation rows, the weights with the smallest error on them are
//! returned.

use granum_core::clock::Instant;
use granum_core::observer::{Flow, Observer};
use granum_simd::{Isa, Kernel, LANES, Lanes, dispatch, mul_add};

use super::kind::TrainerKind;
use super::options::Options;
use super::report::TrainingReport;
use super::state::{TrainerState, TrainingHistory, Validation};
use super::trainer_trait::{SharedTrainer, Trainer, training_progress};
use crate::differentiable::check_columns;
use crate::differentiable::{Batch, Differentiable};
use crate::table::data::Data;
use crate::training_error::{TerminationReason, TrainingError};

/// The entry of the registry.
pub(super) const KIND: TrainerKind = TrainerKind {
    name: Traingdx::NAME,
    help: "gradient descent with momentum and an adaptive learning rate, the paper's trainer",
    make: |options| Traingdx::with_options(options).into(),
};

/// Gradient descent with momentum and adaptive learning rate. The defaults are those of the toolbox.
#[derive(Clone, Debug, PartialEq)]
pub struct Traingdx {
    /// Largest number of epochs; the tables of the paper give 60,000 to 150,000 (default 120,000).
    pub epochs: u64,
    /// Mean squared error at which training ends (0).
    pub goal: f64,
    /// Norm of the gradient of the mean squared error at which training ends (1e-6).
    pub minimum_gradient: f64,
    /// Number of accepted steps without a decrease of the validation error after which training ends (6).
    pub maximum_failures: u64,
    /// Initial learning rate (0.01).
    pub learning_rate: f64,
    /// Factor on the rate after a step that lowers the error (1.05).
    pub increase: f64,
    /// Factor on the rate after a rejected step (0.7).
    pub decrease: f64,
    /// A step is rejected if the error rises by more than this factor (1.04).
    pub largest_rise: f64,
    /// Momentum (0.9).
    pub momentum: f64,
    /// Instruction set; results do not depend on it.
    pub isa: Isa,
}

impl Default for Traingdx {
    fn default() -> Self {
        Traingdx {
            epochs: 120_000,
            goal: 0.0,
            minimum_gradient: 1e-6,
            maximum_failures: 6,
            learning_rate: 0.01,
            increase: 1.05,
            decrease: 0.7,
            largest_rise: 1.04,
            momentum: 0.9,
            isa: Isa::detect(),
        }
    }
}

impl Traingdx {
    /// Name of the trainer in commands and records.
    pub const NAME: &'static str = "traingdx";

    /// The defaults, changed by the options.
    pub fn with_options(options: &Options) -> Traingdx {
        Traingdx::default().changed(options)
    }

    /// The same trainer with the given options applied.
    fn changed(&self, options: &Options) -> Traingdx {
        Traingdx {
            epochs: options.epochs.unwrap_or(self.epochs),
            goal: options.goal.unwrap_or(self.goal),
            minimum_gradient: options.minimum_gradient.unwrap_or(self.minimum_gradient),
            maximum_failures: options.maximum_failures.unwrap_or(self.maximum_failures),
            isa: options.isa.unwrap_or(self.isa),
            ..self.clone()
        }
    }
}

impl Trainer for Traingdx {
    fn name(&self) -> &str {
        Traingdx::NAME
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
        check_columns(model, data)?;
        let clock = Instant::now();
        let mut descent = Descent::start(self, model, data, state)?;
        let termination = descent.run(observer);
        let mut error = descent.error;
        let mut validation_error = descent.validation_error;
        model.weights_mut().copy_from_slice(&descent.weights);
        if let Some(best) = descent.history.best_at(termination) {
            model.weights_mut().copy_from_slice(&best.weights);
            error = descent.batch.squared_error(&best.weights) / descent.values;
            validation_error = Some(best.error);
        }
        Ok(TrainingReport {
            validation_error,
            seconds: clock.elapsed().as_secs_f64(),
            ..TrainingReport::new(descent.state(), error, termination)
        })
    }
}

/// The names of the last step and the learning rate in a state.
const STEP: &str = "step";
const RATE: &str = "rate";

/// The state of a gradient descent.
struct Descent<'a> {
    rule: &'a Traingdx,
    batch: Box<dyn Batch>,
    validation: Option<Validation>,
    /// Number of errors, rows times targets.
    values: f64,
    weights: Vec<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
    gradient: Vec<f64>,
    rate: f64,
    error: f64,
    validation_error: Option<f64>,
    history: TrainingHistory,
}

impl<'a> Descent<'a> {
    fn start(
        rule: &'a Traingdx,
        model: &dyn Differentiable,
        data: &Data,
        state: Option<TrainerState>,
    ) -> Result<Descent<'a>, TrainingError> {
        let count = model.weights().len();
        let fresh = state.is_none();
        let state = state.unwrap_or_else(|| {
            TrainerState::new(Traingdx::NAME, model.weights().to_vec())
                .with(STEP, &vec![0.0; count])
                .with(RATE, &[rule.learning_rate])
        });
        state.check(Traingdx::NAME, model)?;
        let (step, rate) = (state.vector(STEP, count)?.to_vec(), state.number(RATE)?);
        let mut descent = Descent {
            rule,
            batch: model.batch(rule.isa, data)?,
            validation: Validation::new(rule.isa, model, data)?,
            values: data.observations() * data.target_columns() as f64,
            trial: state.weights.clone(),
            weights: state.weights,
            step,
            gradient: vec![0.0; count],
            rate,
            error: 0.0,
            validation_error: None,
            history: state.history,
        };
        descent.error = descent.batch.squared_error(&descent.weights) / descent.values;
        if !descent.error.is_finite() {
            return Err(TrainingError::NotFinite(descent.error));
        }
        descent.batch.gradient(&descent.weights, 2.0 / descent.values, &mut descent.gradient);
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
        TrainerState::with_history(Traingdx::NAME, self.weights.clone(), self.history.clone())
            .with(STEP, &self.step)
            .with(RATE, &[self.rate])
    }

    fn run(&mut self, observer: &mut dyn Observer) -> TerminationReason {
        loop {
            if let Some(reason) = self.finished() {
                return reason;
            }
            self.epoch();
            let (epoch, epochs) = (self.history.epoch, self.rule.epochs);
            let progress = training_progress(epoch, epochs, self.error, self.validation_error);
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
        } else if norm(self.rule.isa, &self.gradient) <= self.rule.minimum_gradient {
            Some(TerminationReason::MinimumGradient)
        } else if self.validation.is_some() && self.history.failures >= self.rule.maximum_failures {
            Some(TerminationReason::ValidationFailures)
        } else {
            None
        }
    }

    /// Performs one trial of the rule.
    fn epoch(&mut self) {
        let rule = self.rule;
        let slope = -(1.0 - rule.momentum) * self.rate;
        dispatch(rule.isa, Step { factor: rule.momentum, slope, descent: self });
        let error = self.batch.squared_error(&self.trial) / self.values;
        self.history.epoch += 1;
        // The comparison is such that an error of NaN is rejected.
        if error <= rule.largest_rise * self.error {
            if error < self.error {
                self.rate *= rule.increase;
            }
            std::mem::swap(&mut self.weights, &mut self.trial);
            self.error = error;
            self.batch.gradient(&self.weights, 2.0 / self.values, &mut self.gradient);
            if let Some(validation) = &mut self.validation {
                let error = validation.error(&self.weights);
                self.validation_error = Some(error);
                self.history.validate(error, &self.weights);
            }
        } else {
            self.rate *= rule.decrease;
            for (step, gradient) in self.step.iter_mut().zip(&self.gradient) {
                *step = -self.rate * gradient;
            }
        }
        self.history.note(self.error, self.validation_error);
    }
}

/// `step <- factor * step + slope * gradient`, `trial <- weights + step`.
struct Step<'a, 'b> {
    factor: f64,
    slope: f64,
    descent: &'a mut Descent<'b>,
}

impl Kernel for Step<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let d = self.descent;
        let (factor, slope) = (L::splat(self.factor), L::splat(self.slope));
        let (steps, last_steps) = d.step.as_chunks_mut::<LANES>();
        let (gradients, last_gradients) = d.gradient.as_chunks::<LANES>();
        let (weights, last_weights) = d.weights.as_chunks::<LANES>();
        let (trials, last_trials) = d.trial.as_chunks_mut::<LANES>();
        for k in 0..steps.len() {
            let step = slope.mul_add(L::load(&gradients[k]), factor * L::load(&steps[k]));
            step.store(&mut steps[k]);
            (L::load(&weights[k]) + step).store(&mut trials[k]);
        }
        for k in 0..last_steps.len() {
            last_steps[k] = mul_add(self.slope, last_gradients[k], self.factor * last_steps[k]);
            last_trials[k] = last_weights[k] + last_steps[k];
        }
    }
}

/// Euclidean norm, summed by lanes.
pub(super) fn norm(isa: Isa, vector: &[f64]) -> f64 {
    struct Norm<'a>(&'a [f64]);
    impl Kernel for Norm<'_> {
        type Output = f64;
        #[inline(always)]
        fn run<L: Lanes>(self) -> f64 {
            let (chunks, rest) = self.0.as_chunks::<LANES>();
            let mut sums = [L::zero(); 4];
            for (k, chunk) in chunks.iter().enumerate() {
                let value = L::load(chunk);
                sums[k % 4] = value.mul_add(value, sums[k % 4]);
            }
            let sum = ((sums[0] + sums[1]) + (sums[2] + sums[3])).reduce_add();
            rest.iter().fold(sum, |sum, v| mul_add(*v, *v, sum)).sqrt()
        }
    }
    dispatch(isa, Norm(vector))
}
