//! Mini-batch gradient descent with adaptive moments, for large tables and for sequences.
//!
//! For the gradient `g` of the mean squared error over a mini-batch, in step `t` (Kingma and Ba 2015):
//!
//! ```text
//! m <- b1 m + (1 - b1) g              v <- b2 v + (1 - b2) g^2
//! w <- w - r (m / (1 - b1^t)) / (sqrt(v / (1 - b2^t)) + 1e-8)
//! ```
//!
//! Gradients longer than [`Adam::longest_gradient`] are shortened to it (Pascanu, Mikolov and Bengio 2013), and the rate
//! falls linearly over the epochs to a hundredth. Every epoch visits all rows or sequences once, in an order that depends on
//! the seed and the number of the epoch only. With validation rows, which should be those of whole runs
//! ([`crate::Data::with_validation_blocks`]), the weights with the smallest error on them are returned.

use granum_core::clock::Instant;
use granum_core::observer::{Flow, Observer};
use granum_simd::Isa;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::kind::TrainerKind;
use super::options::Options;
use super::report::TrainingReport;
use super::state::{TrainerState, TrainingHistory, Validation};
use super::trainer_trait::{SharedTrainer, Trainer, training_progress};
use super::traingdx::norm;
use crate::differentiable::Differentiable;
use crate::differentiable::check_columns;
use crate::table::data::Data;
use crate::training_error::{TerminationReason, TrainingError};

/// The entry of the registry.
pub(super) const KIND: TrainerKind = TrainerKind {
    name: Adam::NAME,
    help: "mini-batch gradient descent with adaptive moments, for large tables and sequences",
    make: |options| Adam::with_options(options).into(),
};

/// Decay of the mean gradient and of the mean squared gradient.
const DECAY: [f64; 2] = [0.9, 0.999];
/// Added to the square root of the mean squared gradient.
const LEAST: f64 = 1e-8;
/// Learning rate at the end of the last epoch, as a share of that of the first.
const LAST_RATE: f64 = 0.01;

/// Mini-batch gradient descent with adaptive moments.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver, Trainer};
/// use granum_nets::{Data, Network};
///
/// let x: Vec<f64> = (0..400).map(|k| f64::from(k) / 199.5 - 1.0).collect();
/// let y = x.iter().map(|x| 0.5 + 0.3 * (3.0 * x).sin()).collect();
/// let mut network = Network::new(&[1, 12, 1], 1)?;
/// let trainer = Adam { epochs: 200, learning_rate: 0.01, ..Adam::default() };
/// let report = trainer.train(&mut network, &Data::new(x, 1, y)?, &mut NoObserver)?;
/// assert!(report.error.sqrt() < 0.05, "{}", report.error.sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Adam {
    /// Largest number of epochs (1000).
    pub epochs: u64,
    /// Mean squared error at which training ends (0).
    pub goal: f64,
    /// Norm of the gradient of a mini-batch at the end of an epoch at which training ends (0).
    pub minimum_gradient: f64,
    /// Number of epochs without a decrease of the validation error after which training ends (100).
    pub maximum_failures: u64,
    /// Learning rate of the first epoch (0.003).
    pub learning_rate: f64,
    /// Number of rows (or observations) in a mini-batch (128).
    pub batch_rows: usize,
    /// Number of sequences in a mini-batch (8).
    pub batch_sequences: usize,
    /// Largest norm of a gradient; longer ones are shortened (1).
    pub longest_gradient: f64,
    /// Seed of the order of the rows or sequences (1).
    pub seed: u64,
    /// Instruction set; results do not depend on it.
    pub isa: Isa,
}

impl Default for Adam {
    fn default() -> Self {
        Adam {
            epochs: 1000,
            goal: 0.0,
            minimum_gradient: 0.0,
            maximum_failures: 100,
            learning_rate: 0.003,
            batch_rows: 128,
            batch_sequences: 8,
            longest_gradient: 1.0,
            seed: 1,
            isa: Isa::detect(),
        }
    }
}

impl Adam {
    /// Name of the trainer in commands and records.
    pub const NAME: &'static str = "adam";

    /// The defaults, changed by the options.
    pub fn with_options(options: &Options) -> Adam {
        Adam::default().changed(options)
    }

    /// The same trainer with the given options applied.
    fn changed(&self, options: &Options) -> Adam {
        Adam {
            epochs: options.epochs.unwrap_or(self.epochs),
            goal: options.goal.unwrap_or(self.goal),
            minimum_gradient: options.minimum_gradient.unwrap_or(self.minimum_gradient),
            maximum_failures: options.maximum_failures.unwrap_or(self.maximum_failures),
            seed: options.seed.unwrap_or(self.seed),
            isa: options.isa.unwrap_or(self.isa),
            ..self.clone()
        }
    }

    fn check(&self) -> Result<(), TrainingError> {
        let positive = |name: &'static str, value: f64| {
            let expected = "a positive number";
            let valid = value > 0.0 && value.is_finite();
            if valid { Ok(()) } else { Err(TrainingError::Option { name, value, expected }) }
        };
        positive("learning_rate", self.learning_rate)?;
        positive("longest_gradient", self.longest_gradient)?;
        positive("batch_rows", self.batch_rows as f64)?;
        positive("batch_sequences", self.batch_sequences as f64)
    }
}

impl Trainer for Adam {
    fn name(&self) -> &str {
        Adam::NAME
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
        self.check()?;
        check_columns(model, data)?;
        let clock = Instant::now();
        let mut descent = Descent::start(self, model, data, state)?;
        let termination = descent.run(model, observer)?;
        let mut validation_error = descent.validation_error;
        model.weights_mut().copy_from_slice(&descent.weights);
        if let Some(best) = descent.history.best_at(termination) {
            model.weights_mut().copy_from_slice(&best.weights);
            validation_error = Some(best.error);
        }
        let values = data.observations() * data.target_columns() as f64;
        let error = model.batch(self.isa, data)?.squared_error(model.weights()) / values;
        Ok(TrainingReport {
            validation_error,
            seconds: clock.elapsed().as_secs_f64(),
            ..TrainingReport::new(descent.state(), error, termination)
        })
    }
}

/// The state of a descent.
struct Descent<'a> {
    rule: &'a Adam,
    data: &'a Data,
    validation: Option<Validation>,
    weights: Vec<f64>,
    gradient: Vec<f64>,
    /// Means of the gradient and of its square.
    moments: [Vec<f64>; 2],
    /// The powers `b1^t` and `b2^t` of the decays.
    powers: [f64; 2],
    /// Mean squared error over the mini-batches of the last epoch.
    error: f64,
    validation_error: Option<f64>,
    history: TrainingHistory,
}

const MOMENTS: [&str; 2] = ["mean_gradient", "mean_squared_gradient"];
const POWERS: &str = "powers";
const ERROR: &str = "error";

impl<'a> Descent<'a> {
    fn start(
        rule: &'a Adam,
        model: &dyn Differentiable,
        data: &'a Data,
        state: Option<TrainerState>,
    ) -> Result<Descent<'a>, TrainingError> {
        let count = model.weights().len();
        let fresh = state.is_none();
        let values = data.observations() * data.target_columns() as f64;
        let state = match state {
            Some(state) => state,
            None => {
                let error = model.batch(rule.isa, data)?.squared_error(model.weights()) / values;
                if !error.is_finite() {
                    return Err(TrainingError::NotFinite(error));
                }
                TrainerState::new(Adam::NAME, model.weights().to_vec())
                    .with(MOMENTS[0], &vec![0.0; count])
                    .with(MOMENTS[1], &vec![0.0; count])
                    .with(POWERS, &[1.0, 1.0])
                    .with(ERROR, &[error])
            }
        };
        state.check(Adam::NAME, model)?;
        let moment = |name: &str| state.vector(name, count).map(<[f64]>::to_vec);
        let moments = [moment(MOMENTS[0])?, moment(MOMENTS[1])?];
        let powers = state.vector(POWERS, 2)?;
        if moments[1].iter().any(|v| *v < 0.0) || powers.iter().any(|power| !(0.0..=1.0).contains(power)) {
            return Err(TrainingError::State("its moments are not valid numbers".into()));
        }
        let mut descent = Descent {
            rule,
            data,
            validation: Validation::new(rule.isa, model, data)?,
            gradient: vec![0.0; count],
            powers: [powers[0], powers[1]],
            moments,
            error: state.number(ERROR)?,
            weights: state.weights,
            validation_error: None,
            history: state.history,
        };
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
        TrainerState::with_history(Adam::NAME, self.weights.clone(), self.history.clone())
            .with(MOMENTS[0], &self.moments[0])
            .with(MOMENTS[1], &self.moments[1])
            .with(POWERS, &self.powers)
            .with(ERROR, &[self.error])
    }

    fn run(
        &mut self,
        model: &dyn Differentiable,
        observer: &mut dyn Observer,
    ) -> Result<TerminationReason, TrainingError> {
        loop {
            if let Some(reason) = self.finished() {
                return Ok(reason);
            }
            let length = self.epoch(model)?;
            let (epoch, epochs) = (self.history.epoch, self.rule.epochs);
            let progress = training_progress(epoch, epochs, self.error, self.validation_error);
            if observer.progress(&progress) == Flow::Stop {
                return Ok(TerminationReason::Stopped);
            }
            if length <= self.rule.minimum_gradient {
                return Ok(TerminationReason::MinimumGradient);
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
        } else {
            None
        }
    }

    /// Visits all members once, and returns the norm of the last gradient.
    fn epoch(&mut self, model: &dyn Differentiable) -> Result<f64, TrainingError> {
        let rule = self.rule;
        let order = shuffled(self.data.members(), rule.seed, self.history.epoch);
        let size = if self.data.sequences().is_some() { rule.batch_sequences } else { rule.batch_rows };
        let share = self.history.epoch as f64 / rule.epochs as f64;
        let rate = rule.learning_rate * (1.0 - (1.0 - LAST_RATE) * share);
        let (mut sum, mut all, mut length) = (0.0, 0.0, f64::INFINITY);
        for chosen in order.chunks(size) {
            let part =
                self.data.only_members(chosen).map_err(|error| TrainingError::Rows(error.to_string()))?;
            let values = part.observations() * part.target_columns() as f64;
            if values <= 0.0 {
                continue;
            }
            let mut batch = model.batch(rule.isa, &part)?;
            let error = batch.squared_error(&self.weights);
            if !error.is_finite() {
                return Err(TrainingError::NotFinite(error));
            }
            batch.gradient(&self.weights, 2.0 / values, &mut self.gradient);
            length = norm(rule.isa, &self.gradient);
            self.step(rate, (rule.longest_gradient / length).min(1.0));
            (sum, all) = (sum + error, all + values);
        }
        self.error = sum / all;
        self.history.epoch += 1;
        if let Some(validation) = &mut self.validation {
            let error = validation.error(&self.weights);
            self.validation_error = Some(error);
            self.history.validate(error, &self.weights);
        }
        self.history.note(self.error, self.validation_error);
        Ok(length)
    }

    /// One step with the gradient times a factor.
    fn step(&mut self, rate: f64, factor: f64) {
        for (power, decay) in self.powers.iter_mut().zip(DECAY) {
            *power *= decay;
        }
        let corrections = self.powers.map(|power| 1.0 / (1.0 - power));
        let [mean, square] = &mut self.moments;
        for k in 0..self.weights.len() {
            let gradient = factor * self.gradient[k];
            mean[k] = DECAY[0] * mean[k] + (1.0 - DECAY[0]) * gradient;
            square[k] = DECAY[1] * square[k] + (1.0 - DECAY[1]) * (gradient * gradient);
            let root = (square[k] * corrections[1]).sqrt() + LEAST;
            self.weights[k] -= rate * (mean[k] * corrections[0]) / root;
        }
    }
}

/// The numbers below `count` in an order that depends on the seed and the epoch (Fisher and Yates).
fn shuffled(count: usize, seed: u64, epoch: u64) -> Vec<usize> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(epoch);
    let mut order: Vec<usize> = (0..count).collect();
    for k in (1..count).rev() {
        // The bias of the remainder is below 2^-40 for tables of any size that fits into memory.
        order.swap(k, (random.next_u64() % (k as u64 + 1)) as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrent::gru::Gru;
    use crate::table::sequences::Sequences;
    use crate::trainer::{LevenbergMarquardt, NoObserver, Progress};

    /// Tests whose target is a decaying memory of the inputs, plus a start value.
    fn memory() -> Data {
        let lengths: Vec<usize> = (0..24).map(|k| 6 + k % 5).collect();
        let wave = |k: usize| (1.3 * k as f64).sin();
        let rows: usize = lengths.iter().sum();
        let inputs: Vec<f64> = (0..rows).map(wave).collect();
        let starts: Vec<f64> = (0..lengths.len()).map(|k| 0.5 * wave(3 * k + 1)).collect();
        let sequences = Sequences::new(lengths).unwrap().with_starts(starts.clone(), 1).unwrap();
        let mut targets = Vec::new();
        for (rows, start) in sequences.ranges().into_iter().zip(starts) {
            let mut state = start;
            for row in rows {
                state = 0.7 * state + 0.3 * inputs[row];
                targets.push(state);
            }
        }
        Data::new(inputs, 1, targets).unwrap().with_sequences(sequences).unwrap()
    }

    #[test]
    fn orders_are_permutations_that_differ() {
        let mut order = shuffled(50, 3, 7);
        assert_ne!(order, shuffled(50, 3, 8));
        assert_ne!(order, shuffled(50, 4, 7));
        assert_eq!(order, shuffled(50, 3, 7));
        order.sort_unstable();
        assert_eq!(order, (0..50).collect::<Vec<_>>());
    }

    #[test]
    fn a_recurrent_unit_learns_a_memory_and_resumes_to_the_same_bits() {
        let data = memory().with_validation_blocks(&[2, 9, 17]).unwrap();
        let rule = Adam { epochs: 120, learning_rate: 0.02, ..Adam::default() };
        let start = Gru::new(1, 1, 6, 1, 4).unwrap();
        let mut whole = start.clone();
        let expected = rule.train(&mut whole, &data, &mut NoObserver).unwrap();
        assert!(expected.validation_error.unwrap().sqrt() < 0.04, "{:?}", expected.validation_error);
        let mut stop = |p: &Progress| if p.done < 31 { Flow::Continue } else { Flow::Stop };
        let stopped = rule.train(&mut start.clone(), &data, &mut stop).unwrap();
        assert_eq!((stopped.termination, stopped.epochs), (TerminationReason::Stopped, 31));
        let text = serde_json::to_string(&stopped.state).unwrap();
        let mut resumed = start.clone();
        let state = serde_json::from_str(&text).unwrap();
        let report = rule.resume(&mut resumed, &data, Some(state), &mut NoObserver).unwrap();
        assert_eq!((resumed, report.state), (whole.clone(), expected.state));
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let mut other = start.clone();
            Adam { isa, ..rule.clone() }.train(&mut other, &data, &mut NoObserver).unwrap();
            assert_eq!(other, whole, "{}", isa.name());
        }
        let mut other = start.clone();
        Adam { seed: 2, ..rule }.train(&mut other, &data, &mut NoObserver).unwrap();
        assert_ne!(other, whole);
    }

    #[test]
    fn trainers_that_need_more_than_a_gradient_say_so() {
        let mut gru = Gru::new(1, 1, 3, 1, 4).unwrap();
        let error = LevenbergMarquardt::default().train(&mut gru, &memory(), &mut NoObserver).unwrap_err();
        let wanted = "levenberg-marquardt cannot train a gated recurrent unit, which provides no Gauss-Newton matrix; \
                      use one of: adam, l-bfgs, traingdx";
        assert_eq!(error.to_string(), wanted);
        // Gradient descent with momentum trains it as well.
        let rule = super::super::Traingdx { epochs: 300, ..Default::default() };
        let report = rule.train(&mut gru, &memory(), &mut NoObserver).unwrap();
        assert!(report.error < 0.3 * report.history[0].error, "{:?}", report.error);
        let wrong = Adam { learning_rate: 0.0, ..Adam::default() };
        let text = wrong.train(&mut gru, &memory(), &mut NoObserver).unwrap_err().to_string();
        assert_eq!(text, "trainer option learning_rate = 0: a positive number");
    }
}
