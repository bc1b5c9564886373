//! Levenberg-Marquardt with Bayesian regularisation: the default trainer.
//!
//! It minimises `E_D + (alpha / beta) E_W`, with `E_D` the weighted sum of squared errors and `E_W` that of the weights.
//! A step solves `(J^T J + (alpha / beta + damping) I) s = -(J^T e + (alpha / beta) w)` (Marquardt 1963; Hagan and Menhaj
//! 1994), in the form that is cheaper, see `curvature.rs`. A step that lowers the objective is taken and the damping
//! divided by ten, otherwise the damping is multiplied by ten and the step tried again.
//!
//! Near a minimum (the last step lowered the objective by less than 0.3 %) the precisions of weights and noise are estimated
//! anew from the evidence before the step (MacKay 1992; Foresee and Hagan 1997), with `n` errors and `gamma` effective
//! parameters:
//!
//! ```text
//! gamma = sum of lambda / (lambda + alpha / beta) over the eigenvalues of J^T J
//! alpha = gamma / E_W,   beta = (n - gamma) / E_D
//! ```
//!
//! `exp(-beta E_D / 2)` is the likelihood and `exp(-alpha E_W / 2)` the prior, so `1 / beta` is the variance of the noise.
//! Rows that share their noise count as fewer errors, see [`Data::with_observations`].
//!
//! These estimates hold at a minimum only. Used from the first step on, as `trainbr` does, they run away to rough functions
//! that go through noisy rows; so training starts with a firm ratio `alpha / beta`, waits for the weights to settle, and lets
//! the ratio fall by no more than a factor of ten at a time.

mod method;

use std::time::Instant;

use granum_simd::{Isa, Row8};

use self::method::Method;
use super::state::{TrainerState, TrainingHistory, Validation};
use super::traingdx::norm;
use super::{
    Control, Evidence, Observer, Options, Progress, SharedTrainer, TerminationReason, Trainer, TrainerKind,
    TrainingError, TrainingReport, check_columns,
};
use crate::backprop::Workspace;
use crate::curvature::Curvature;
use crate::data::Data;
use crate::kernels::blocks;
use crate::network::Network;

/// Most memory for the matrices, in bytes.
const MEMORY: usize = 2 << 30;

/// How it is found by name.
pub(super) const KIND: TrainerKind = TrainerKind {
    name: LevenbergMarquardt::NAME,
    help: "Levenberg-Marquardt with Bayesian regularisation",
    make: |options| LevenbergMarquardt::with_options(options).into(),
};

/// How large weights are held back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Regularisation {
    /// By the evidence in the data.
    Bayesian,
    /// By a fixed ratio `alpha / beta`; zero for none.
    Fixed(f64),
}

/// Levenberg-Marquardt with Bayesian regularisation.
#[derive(Clone, Debug, PartialEq)]
pub struct LevenbergMarquardt {
    /// Most epochs (500).
    pub epochs: u64,
    /// Mean squared error at which training ends (0).
    pub goal: f64,
    /// Norm of the gradient of the objective over the number of errors at which training ends (1e-9).
    pub minimum_gradient: f64,
    /// Accepted steps without a fall of the validation error after which training ends (6).
    pub maximum_failures: u64,
    /// Regularisation (Bayesian).
    pub regularisation: Regularisation,
    /// First ratio `alpha / beta` of Bayesian regularisation over the mean squared deviation of the targets (0.04). Training finds
    /// the smoothest function first that the data allow from here on; a function with a sharp shape that the data determine
    /// well, such as a distribution, wants a looser start, or the search ends at a coarse likeness of it.
    pub first_ratio: f64,
    /// First damping (1).
    pub damping: f64,
    /// Damping at which training ends, as no step lowers the objective (1e10).
    pub maximum_damping: f64,
    /// Relative change of the objective below which an epoch is quiet (1e-3); three quiet epochs in a row end the training.
    pub tolerance: f64,
    /// Instruction set; the bits are the same on each.
    pub isa: Isa,
}

/// Quiet epochs in a row that end the training.
const QUIET: u64 = 3;
/// Relative change of the effective number of parameters below which an epoch is quiet.
const GAMMA_TOLERANCE: f64 = 0.02;
/// With no more independent observations than this the regularisation never gets firmer than where something was learned
/// first; with more, by as much as they are more.
const FEW_OBSERVATIONS: f64 = 8.0;
/// Least damping: below this it no longer matters.
const LEAST_DAMPING: f64 = 1e-20;
/// If the first minimum leaves more than this share of the deviation, the regularisation was too firm (all weights vanish).
const NOTHING_LEARNED: f64 = 0.9;
/// Least first ratio over the squared deviation.
const LEAST_RATIO: f64 = 1e-8;
/// Relative fall of the objective in a step below which the weights count as near a minimum.
const SETTLED: f64 = 0.003;
/// The ratio `alpha / beta` falls by no more than this in an epoch, so that smooth functions are tried before rough ones.
const LARGEST_FALL: f64 = 0.1;
/// Least share of the errors that counts as noise, so that data without noise keep a finite precision.
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
    /// Its name in commands and records.
    pub const NAME: &'static str = "levenberg-marquardt";

    /// The defaults, changed by the options.
    pub fn with_options(options: &Options) -> LevenbergMarquardt {
        LevenbergMarquardt::default().changed(options)
    }

    /// The same, changed by the options.
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

    /// Where regularisation starts: firmly enough to find a smooth function first, loosely enough not to find none.
    fn first_evidence(&self, data: &Data, weights: usize) -> Evidence {
        let ratio = match self.regularisation {
            Regularisation::Bayesian => self.first_ratio * deviation(data) / data.observations(),
            Regularisation::Fixed(ratio) => ratio,
        };
        Evidence { alpha: ratio, beta: 1.0, gamma: weights as f64 }
    }
}

/// Sum over all targets of the weighted squared deviation from their column's mean.
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
        network: &mut Network,
        data: &Data,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError> {
        check_columns(network, data)?;
        let clock = Instant::now();
        let mut search = Search::start(self, network, data, state)?;
        let termination = search.run(observer);
        let mut error = search.squared_error / search.values;
        let mut validation_error = search.validation_error;
        network.weights_mut().copy_from_slice(&search.weights);
        if let (Some(best), false) = (&search.history.best, termination == TerminationReason::Stopped) {
            network.weights_mut().copy_from_slice(&best.weights);
            error = search.workspace.squared_error(&best.weights) / search.values;
            validation_error = Some(best.error);
        }
        let left_out = match termination {
            TerminationReason::Stopped => None,
            _ => search.left_out(network.weights(), data),
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

/// A search on its way.
struct Search<'a> {
    rule: &'a LevenbergMarquardt,
    workspace: Workspace,
    curvature: Curvature,
    validation: Option<Validation>,
    /// Number of independent errors: observations times targets.
    values: f64,
    weights: Vec<f64>,
    trial: Vec<f64>,
    gradient: Vec<f64>,
    residuals: Vec<Row8>,
    /// `E_D` and `E_W`.
    squared_error: f64,
    squared_weights: f64,
    damping: f64,
    evidence: Evidence,
    /// The weights to start again from, until the first regularisation has proved not to be too firm.
    start: Option<Vec<f64>>,
    /// Squared deviation of the targets from their means.
    deviation: f64,
    /// Largest ratio `alpha / beta`, from that with which something was learned first. With a handful of independent
    /// observations the evidence alone would let all weights vanish.
    ceiling: f64,
    /// The last step changed little: the weights are near a minimum for the present regularisation.
    settled: bool,
    /// Epochs in a row without change.
    quiet: u64,
    validation_error: Option<f64>,
    history: TrainingHistory,
}

impl<'a> Search<'a> {
    fn start(
        rule: &'a LevenbergMarquardt,
        network: &Network,
        data: &Data,
        state: Option<TrainerState>,
    ) -> Result<Search<'a>, TrainingError> {
        let (rows, count) = (data.rows() * data.target_columns(), network.weights().len());
        let bytes = Curvature::bytes(rows, rows / data.points(), count)
            .saturating_add(Workspace::bytes(network, rows));
        if bytes > MEMORY {
            let trainer = LevenbergMarquardt::NAME;
            return Err(TrainingError::Memory { trainer, rows, weights: count, bytes, limit: MEMORY });
        }
        let fresh = state.is_none();
        let state = state.unwrap_or_else(|| {
            let bayesian = rule.regularisation == Regularisation::Bayesian;
            let method = Method {
                damping: rule.damping,
                evidence: rule.first_evidence(data, count),
                start: bayesian.then(|| network.weights().to_vec()),
                ceiling: f64::MAX,
                settled: false,
                quiet: 0,
            };
            method.into_state(TrainerState::new(LevenbergMarquardt::NAME, network.weights().to_vec()))
        });
        state.check(LevenbergMarquardt::NAME, network)?;
        let Method { damping, evidence, start, ceiling, settled, quiet } = Method::of(&state, count)?;
        let workspace = Workspace::of_residuals(rule.isa, network, data);
        let mut search = Search {
            rule,
            curvature: Curvature::new(&workspace, count),
            validation: Validation::new(rule.isa, network, data),
            values: data.observations() * data.target_columns() as f64,
            trial: state.weights.clone(),
            weights: state.weights,
            gradient: vec![0.0; count],
            residuals: vec![Row8::default(); blocks(workspace.observations())],
            workspace,
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
        search.squared_error = search.workspace.squared_error(&search.weights);
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
            let progress = Progress {
                epoch: self.history.epoch,
                epochs: self.rule.epochs,
                error: self.squared_error / self.values,
                validation_error: self.validation_error,
                state: &|| self.state(),
            };
            if observer.progress(&progress) == Control::Stop {
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

    /// One accepted step, or the reason why there is none.
    fn epoch(&mut self) -> Result<(), TerminationReason> {
        if self.settled && self.start.is_some() {
            self.judge_start();
        }
        self.workspace.sensitivities(&self.weights);
        self.workspace.residuals(&mut self.residuals);
        if !self.curvature.form(&self.workspace) {
            return Err(TerminationReason::MaximumDamping);
        }
        let gamma = self.evidence.gamma;
        if self.rule.regularisation == Regularisation::Bayesian && self.settled {
            self.update_evidence();
        }
        let decay = self.decay();
        self.workspace.transposed_jacobian_times(&self.residuals, &mut self.gradient);
        for (g, w) in self.gradient.iter_mut().zip(&self.weights) {
            *g = decay.mul_add(*w, *g) * (2.0 / self.values);
        }
        if norm(self.rule.isa, &self.gradient) <= self.rule.minimum_gradient {
            return Err(TerminationReason::MinimumGradient);
        }
        let before = decay.mul_add(self.squared_weights, self.squared_error);
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

    /// If the first minimum is that of vanishing weights, where no gradient leads away, starts again with a tenth of the
    /// regularisation.
    fn judge_start(&mut self) {
        let Some(start) = self.start.take() else { return };
        let decay = self.decay();
        if self.squared_error > NOTHING_LEARNED * self.deviation && decay > LEAST_RATIO * self.deviation {
            self.evidence.alpha *= 0.1;
            self.damping = self.rule.damping;
            self.settled = false;
            self.weights.copy_from_slice(&start);
            self.squared_error = self.workspace.squared_error(&start);
            self.squared_weights = square(self.rule.isa, &start);
            self.start = Some(start);
        } else {
            self.ceiling = decay * (self.values / FEW_OBSERVATIONS).max(1.0);
        }
    }

    /// Takes a step that lowers the objective; its value there.
    fn descend(&mut self, decay: f64, before: f64) -> Result<f64, TerminationReason> {
        while self.damping <= self.rule.maximum_damping {
            let shift = decay + self.damping;
            if self.curvature.factorise(shift) {
                let (workspace, trial) = (&mut self.workspace, &mut self.trial);
                self.curvature.step(workspace, &self.residuals, &self.weights, decay, shift, trial);
                for (t, w) in trial.iter_mut().zip(&self.weights) {
                    *t += w;
                }
                let squared_error = workspace.squared_error(trial);
                let squared_weights = square(self.rule.isa, trial);
                let after = decay.mul_add(squared_weights, squared_error);
                if after < before {
                    self.squared_error = squared_error;
                    self.squared_weights = squared_weights;
                    std::mem::swap(&mut self.weights, &mut self.trial);
                    self.damping = (self.damping * 0.1).max(LEAST_DAMPING);
                    return Ok(after);
                }
                // The deltas still belong to the old weights, the outputs must again.
                self.workspace.squared_error(&self.weights);
            }
            self.damping *= 10.0;
        }
        Err(TerminationReason::MaximumDamping)
    }

    /// Errors of the observations of each block if the block had not been trained on; nothing for a single block.
    fn left_out(&mut self, weights: &[f64], data: &Data) -> Option<Vec<f64>> {
        if data.block_count() < 2 || data.target_columns() > 1 || self.decay() <= 0.0 {
            return None;
        }
        self.workspace.squared_error(weights);
        self.workspace.sensitivities(weights);
        self.workspace.residuals(&mut self.residuals);
        let shift = self.decay();
        if !self.curvature.form(&self.workspace) || !self.curvature.factorise(shift) {
            return None;
        }
        let weights = data.observation_weights();
        let residuals = &Row8::numbers(&self.residuals)[..weights.len()];
        let mut errors = self.curvature.left_out_residuals(data.blocks(), residuals, shift)?;
        for (error, weight) in errors.iter_mut().zip(&weights) {
            *error = if *weight > 0.0 { *error / weight.sqrt() } else { f64::NAN };
        }
        Some(errors)
    }

    /// Estimates the precisions of weights and noise at the present weights.
    fn update_evidence(&mut self) {
        let decay = self.decay();
        if !self.curvature.factorise(decay) {
            return;
        }
        let gamma = self.curvature.effective_parameters(decay).clamp(f64::MIN_POSITIVE, self.values);
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
