//! Levenberg-Marquardt with Bayesian regularisation: the default trainer.
//!
//! It minimises `E_D + (alpha / beta) E_W`, where `E_D` is the weighted sum of squared errors and `E_W` the sum of squared
//! weights. A step solves `(J^T J + (alpha / beta + damping) I) s = -(J^T e + (alpha / beta) w)` (Marquardt 1963; Hagan and
//! Menhaj 1994) in the form of `curvature.rs`. A step that lowers the objective is accepted, and the damping is divided by
//! ten; otherwise the damping is multiplied by ten, and the step is computed again.
//!
//! Near a minimum, that is if the last step lowered the objective by less than 0.3 %, the precisions of weights and noise
//! are re-estimated from the evidence before the step (MacKay 1992; Foresee and Hagan 1997), with `n` errors and `gamma`
//! effective parameters:
//!
//! ```text
//! gamma = sum of lambda / (lambda + alpha / beta) over the eigenvalues of J^T J
//! alpha = gamma / E_W,   beta = (n - gamma) / E_D
//! ```
//!
//! `exp(-beta E_D / 2)` is the likelihood and `exp(-alpha E_W / 2)` the prior, so `1 / beta` is the variance of the noise.
//! Rows with common noise count as fewer errors, see [`Data::with_observations`].
//!
//! These estimates are valid only at a minimum. If they are used from the first step on, as in `trainbr`, they diverge
//! towards rough functions that interpolate noisy rows. Training therefore starts with a large ratio `alpha / beta`, waits
//! until the weights have settled, and lets the ratio decrease by at most a factor of ten at a time.

mod method;

use granum_core::clock::Instant;
use granum_core::observer::{Flow, Observer};
use granum_simd::{Isa, mul_add};

use self::method::Method;
use super::kind::TrainerKind;
use super::left_out::left_out_of;
use super::options::Options;
use super::report::{Evidence, TrainingReport};
use super::state::{TrainerState, TrainingHistory, Validation};
use super::trainer_trait::{SharedTrainer, Trainer, training_progress};
use super::traingdx::norm;
use crate::differentiable::check_columns;
use crate::differentiable::{Differentiable, GaussNewton};
use crate::table::data::Data;
use crate::training_error::{TerminationReason, TrainingError};

/// The entry of the registry.
pub(super) const KIND: TrainerKind = TrainerKind {
    name: LevenbergMarquardt::NAME,
    help: "Levenberg-Marquardt with Bayesian regularisation",
    make: |options| LevenbergMarquardt::with_options(options).into(),
};

/// The regularisation of the weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Regularisation {
    /// The ratio `alpha / beta` is determined from the evidence.
    Bayesian,
    /// The ratio `alpha / beta` is fixed; zero for no regularisation.
    Fixed(f64),
}

/// Levenberg-Marquardt with Bayesian regularisation.
#[derive(Clone, Debug, PartialEq)]
pub struct LevenbergMarquardt {
    /// Largest number of epochs (500).
    pub epochs: u64,
    /// Mean squared error at which training ends (0).
    pub goal: f64,
    /// Norm of the gradient of the objective over the number of errors at which training ends (1e-9).
    pub minimum_gradient: f64,
    /// Number of accepted steps without a decrease of the validation error after which training ends (6).
    pub maximum_failures: u64,
    /// Regularisation (Bayesian).
    pub regularisation: Regularisation,
    /// Initial ratio `alpha / beta` of Bayesian regularisation over the mean squared deviation of the targets (0.04).
    /// Training first finds the smoothest function that the data allow with this ratio. A function with sharp features
    /// that the data determine well, such as a distribution, needs a smaller initial ratio, since otherwise the search
    /// ends at a coarse approximation of it.
    pub first_ratio: f64,
    /// Initial damping (1).
    pub damping: f64,
    /// Damping at which training ends, since no step lowers the objective (1e10).
    pub maximum_damping: f64,
    /// Relative change of the objective below which an epoch counts as converged (1e-3); three such epochs in a row end the
    /// training.
    pub tolerance: f64,
    /// Instruction set; results do not depend on it.
    pub isa: Isa,
}

/// Number of converged epochs in a row that ends the training.
const QUIET: u64 = 3;
/// Relative change of the effective number of parameters below which an epoch counts as converged.
const GAMMA_TOLERANCE: f64 = 0.02;
/// With at most this number of independent observations, the ratio `alpha / beta` may not exceed the value with which the
/// network first learned something; with more observations the limit grows in proportion to their number.
const FEW_OBSERVATIONS: f64 = 8.0;
/// Lower limit of the damping, below which it has no effect.
const LEAST_DAMPING: f64 = 1e-20;
/// If the error at the first minimum exceeds this share of the squared deviation of the targets, the regularisation was too
/// strong, so that all weights vanish.
const NOTHING_LEARNED: f64 = 0.9;
/// Lower limit of the initial ratio over the squared deviation.
const LEAST_RATIO: f64 = 1e-8;
/// Relative decrease of the objective in a step below which the weights are considered to be near a minimum.
const SETTLED: f64 = 0.003;
/// Largest decrease of the ratio `alpha / beta` in an epoch, as a factor, so that smooth functions are tried before rough
/// ones.
const LARGEST_FALL: f64 = 0.1;
/// Smallest share of the errors that is attributed to noise, so that the precision remains finite for data without noise.
const LEAST_NOISE: f64 = 1e-3;

impl Default for LevenbergMarquardt {
    fn default() -> Self {
        LevenbergMarquardt {
            epochs: 500,
            goal: 0.0,
            minimum_gradient: 1e-9,
            maximum_failures: 6,
            regularisation: Regularisation::Bayesian,
            first_ratio: 0.04,
            damping: 1.0,
            maximum_damping: 1e10,
            tolerance: 1e-3,
            isa: Isa::detect(),
        }
    }
}

impl LevenbergMarquardt {
    /// Name of the trainer in commands and records.
    pub const NAME: &'static str = "levenberg-marquardt";

    /// The defaults, changed by the options.
    pub fn with_options(options: &Options) -> LevenbergMarquardt {
        LevenbergMarquardt::default().changed(options)
    }

    /// The same trainer with the given options applied.
    fn changed(&self, options: &Options) -> LevenbergMarquardt {
        LevenbergMarquardt {
            epochs: options.epochs.unwrap_or(self.epochs),
            goal: options.goal.unwrap_or(self.goal),
            minimum_gradient: options.minimum_gradient.unwrap_or(self.minimum_gradient),
            maximum_failures: options.maximum_failures.unwrap_or(self.maximum_failures),
            first_ratio: options.first_ratio.unwrap_or(self.first_ratio),
            isa: options.isa.unwrap_or(self.isa),
            ..self.clone()
        }
    }

    /// Initial regularisation: strong enough to find a smooth function first, but not so strong that all weights vanish.
    fn first_evidence(&self, data: &Data, weights: usize) -> Evidence {
        let ratio = match self.regularisation {
            Regularisation::Bayesian => self.first_ratio * deviation(data) / data.observations(),
            Regularisation::Fixed(ratio) => ratio,
        };
        Evidence { alpha: ratio, beta: 1.0, gamma: weights as f64 }
    }
}

/// Weighted sum over all targets of the squared deviation from the mean of their column.
fn deviation(data: &Data) -> f64 {
    let m = data.target_columns();
    let weight = |r: usize| data.weights().map_or(1.0, |w| w[r]);
    let mut total = 0.0;
    for c in 0..m {
        let values = || data.targets().iter().skip(c).step_by(m).enumerate();
        let mean = values().map(|(r, t)| weight(r) * t).sum::<f64>() / data.observations();
        total += values().map(|(r, t)| weight(r) * (t - mean) * (t - mean)).sum::<f64>();
    }
    total.max(f64::MIN_POSITIVE)
}

impl Trainer for LevenbergMarquardt {
    fn name(&self) -> &str {
        LevenbergMarquardt::NAME
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
        let mut search = Search::start(self, model, data, state)?;
        let termination = search.run(observer);
        let mut error = search.squared_error / search.values;
        let mut validation_error = search.validation_error;
        model.weights_mut().copy_from_slice(&search.weights);
        if let Some(best) = search.history.best_at(termination) {
            model.weights_mut().copy_from_slice(&best.weights);
            error = search.problem.squared_error(&best.weights) / search.values;
            validation_error = Some(best.error);
        }
        let left_out = match termination {
            TerminationReason::Stopped => None,
            _ => {
                let shift = search.decay();
                left_out_of(search.problem.as_mut(), model.weights(), data, shift)
            }
        };
        Ok(TrainingReport {
            validation_error,
            evidence: (self.regularisation == Regularisation::Bayesian).then_some(search.evidence),
            left_out,
            seconds: clock.elapsed().as_secs_f64(),
            ..TrainingReport::new(search.state(), error, termination)
        })
    }
}

/// The state of a Levenberg-Marquardt search.
struct Search<'a> {
    rule: &'a LevenbergMarquardt,
    problem: Box<dyn GaussNewton>,
    validation: Option<Validation>,
    /// Number of independent errors: observations times targets.
    values: f64,
    weights: Vec<f64>,
    trial: Vec<f64>,
    gradient: Vec<f64>,
    /// `E_D` and `E_W`.
    squared_error: f64,
    squared_weights: f64,
    damping: f64,
    evidence: Evidence,
    /// The initial weights for another attempt, as long as the initial regularisation may turn out to be too strong.
    start: Option<Vec<f64>>,
    /// Squared deviation of the targets from their means.
    deviation: f64,
    /// Upper limit of the ratio `alpha / beta`, derived from the one with which the network first learned something. With
    /// few independent observations, the evidence alone would let all weights vanish.
    ceiling: f64,
    /// True if the last step changed little, so that the weights are near a minimum for the current regularisation.
    settled: bool,
    /// Number of converged epochs in a row.
    quiet: u64,
    validation_error: Option<f64>,
    history: TrainingHistory,
}

impl<'a> Search<'a> {
    fn start(
        rule: &'a LevenbergMarquardt,
        model: &dyn Differentiable,
        data: &Data,
        state: Option<TrainerState>,
    ) -> Result<Search<'a>, TrainingError> {
        let count = model.weights().len();
        let problem = model.gauss_newton(rule.isa, data)?.ok_or_else(|| TrainingError::NoGaussNewton {
            trainer: LevenbergMarquardt::NAME,
            model: model.name().to_owned(),
            others: "adam, l-bfgs, traingdx",
        })?;
        let fresh = state.is_none();
        let state = state.unwrap_or_else(|| {
            let bayesian = rule.regularisation == Regularisation::Bayesian;
            let method = Method {
                damping: rule.damping,
                evidence: rule.first_evidence(data, count),
                start: bayesian.then(|| model.weights().to_vec()),
                ceiling: f64::MAX,
                settled: false,
                quiet: 0,
            };
            method.into_state(TrainerState::new(LevenbergMarquardt::NAME, model.weights().to_vec()))
        });
        state.check(LevenbergMarquardt::NAME, model)?;
        let Method { damping, evidence, start, ceiling, settled, quiet } = Method::from_state(&state, count)?;
        let mut search = Search {
            rule,
            problem,
            validation: Validation::new(rule.isa, model, data)?,
            values: data.observations() * data.target_columns() as f64,
            trial: state.weights.clone(),
            weights: state.weights,
            gradient: vec![0.0; count],
            squared_error: 0.0,
            squared_weights: 0.0,
            damping,
            evidence,
            start,
            deviation: deviation(data),
            ceiling,
            settled,
            quiet,
            validation_error: None,
            history: state.history,
        };
        search.squared_error = search.problem.squared_error(&search.weights);
        search.squared_weights = square(rule.isa, &search.weights);
        if !search.squared_error.is_finite() {
            return Err(TrainingError::NotFinite(search.squared_error));
        }
        search.validation_error = search.validation.as_mut().map(|v| v.error(&search.weights));
        if fresh {
            if let Some(error) = search.validation_error {
                search.history.validate(error, &search.weights);
            }
            search.history.note(search.squared_error / search.values, search.validation_error);
        }
        Ok(search)
    }

    fn state(&self) -> TrainerState {
        let method = Method {
            damping: self.damping,
            evidence: self.evidence,
            start: self.start.clone(),
            ceiling: self.ceiling,
            settled: self.settled,
            quiet: self.quiet,
        };
        let (weights, history) = (self.weights.clone(), self.history.clone());
        method.into_state(TrainerState::with_history(LevenbergMarquardt::NAME, weights, history))
    }

    fn run(&mut self, observer: &mut dyn Observer) -> TerminationReason {
        loop {
            if let Some(reason) = self.finished() {
                return reason;
            }
            if let Err(reason) = self.epoch() {
                return reason;
            }
            let (epoch, epochs) = (self.history.epoch, self.rule.epochs);
            let error = self.squared_error / self.values;
            let progress = training_progress(epoch, epochs, error, self.validation_error);
            if observer.progress(&progress) == Flow::Stop {
                return TerminationReason::Stopped;
            }
        }
    }

    fn finished(&self) -> Option<TerminationReason> {
        if self.squared_error / self.values <= self.rule.goal {
            Some(TerminationReason::Goal)
        } else if self.history.epoch >= self.rule.epochs {
            Some(TerminationReason::EpochLimit)
        } else if self.quiet >= QUIET {
            Some(TerminationReason::Converged)
        } else if self.validation.is_some() && self.history.failures >= self.rule.maximum_failures {
            Some(TerminationReason::ValidationFailures)
        } else {
            None
        }
    }

    /// Ratio `alpha / beta`.
    fn decay(&self) -> f64 {
        self.evidence.alpha / self.evidence.beta
    }

    /// Performs one accepted step, or returns the reason why there is none.
    fn epoch(&mut self) -> Result<(), TerminationReason> {
        if self.settled && self.start.is_some() {
            self.judge_start();
        }
        if !self.problem.linearise(&self.weights) {
            return Err(TerminationReason::MaximumDamping);
        }
        let gamma = self.evidence.gamma;
        if self.rule.regularisation == Regularisation::Bayesian && self.settled {
            self.update_evidence();
        }
        let decay = self.decay();
        self.problem.projected_residuals(&mut self.gradient);
        for (g, w) in self.gradient.iter_mut().zip(&self.weights) {
            *g = mul_add(decay, *w, *g) * (2.0 / self.values);
        }
        if norm(self.rule.isa, &self.gradient) <= self.rule.minimum_gradient {
            return Err(TerminationReason::MinimumGradient);
        }
        let before = mul_add(decay, self.squared_weights, self.squared_error);
        let after = self.descend(decay, before)?;
        self.history.epoch += 1;
        if let Some(validation) = &mut self.validation {
            let error = validation.error(&self.weights);
            self.validation_error = Some(error);
            self.history.validate(error, &self.weights);
        }
        self.history.note(self.squared_error / self.values, self.validation_error);
        let still = |new: f64, old: f64| (new - old).abs() <= self.rule.tolerance * old.abs();
        self.settled = before - after <= SETTLED * before;
        let alike = (self.evidence.gamma - gamma).abs() <= GAMMA_TOLERANCE * gamma;
        let quiet = self.settled && still(after, before) && alike;
        self.quiet = if quiet { self.quiet + 1 } else { 0 };
        Ok(())
    }

    /// Starts again with a tenth of the regularisation if the weights vanish at the first minimum, since there the gradient
    /// vanishes as well.
    fn judge_start(&mut self) {
        let Some(start) = self.start.take() else { return };
        let decay = self.decay();
        if self.squared_error > NOTHING_LEARNED * self.deviation && decay > LEAST_RATIO * self.deviation {
            self.evidence.alpha *= 0.1;
            self.damping = self.rule.damping;
            self.settled = false;
            self.weights.copy_from_slice(&start);
            self.squared_error = self.problem.squared_error(&start);
            self.squared_weights = square(self.rule.isa, &start);
            self.start = Some(start);
        } else {
            self.ceiling = decay * (self.values / FEW_OBSERVATIONS).max(1.0);
        }
    }

    /// Finds a step that lowers the objective, and returns the new value of the objective.
    fn descend(&mut self, decay: f64, before: f64) -> Result<f64, TerminationReason> {
        while self.damping <= self.rule.maximum_damping {
            let shift = decay + self.damping;
            if self.problem.factorise(shift) {
                let (problem, trial) = (&mut self.problem, &mut self.trial);
                problem.step(&self.weights, decay, shift, trial);
                for (t, w) in trial.iter_mut().zip(&self.weights) {
                    *t += w;
                }
                let squared_error = problem.squared_error(trial);
                let squared_weights = square(self.rule.isa, trial);
                let after = mul_add(decay, squared_weights, squared_error);
                if after < before {
                    self.squared_error = squared_error;
                    self.squared_weights = squared_weights;
                    std::mem::swap(&mut self.weights, &mut self.trial);
                    self.damping = (self.damping * 0.1).max(LEAST_DAMPING);
                    return Ok(after);
                }
                // The outputs must be recomputed for the old weights, to which the deltas still belong.
                self.problem.squared_error(&self.weights);
            }
            self.damping *= 10.0;
        }
        Err(TerminationReason::MaximumDamping)
    }

    /// Estimates the precisions of weights and noise at the current weights.
    fn update_evidence(&mut self) {
        let decay = self.decay();
        if !self.problem.factorise(decay) {
            return;
        }
        let gamma = self.problem.effective_parameters(decay).clamp(f64::MIN_POSITIVE, self.values);
        let noise = (self.values - gamma).max(LEAST_NOISE * self.values);
        let alpha = gamma / self.squared_weights.max(f64::MIN_POSITIVE);
        let beta = noise / self.squared_error.max(f64::MIN_POSITIVE);
        let alpha = alpha.max(LARGEST_FALL * decay * beta).min(self.ceiling * beta);
        if alpha.is_finite() && beta.is_finite() {
            self.evidence = Evidence { alpha, beta, gamma };
        }
    }
}

/// Sum of squares.
fn square(isa: Isa, vector: &[f64]) -> f64 {
    let norm = norm(isa, vector);
    norm * norm
}
