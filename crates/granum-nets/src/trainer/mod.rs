//! The trainers, which share one trait and have one file each.
//!
//! All functions that train accept a `&dyn Trainer`, so that user-defined trainers can be used like those of this crate; the
//! registry of names ([`by_name`]) is built on top. [`crate::Objective`] provides the error of a network and its gradient:
//!
//! ```
//! use granum_nets::trainer::{
//!     Control, Observer, Progress, Silent, TerminationReason, Trainer, TrainerState, TrainingError, TrainingReport,
//! };
//! use granum_nets::{Column, Data, Model, Network, Objective, Recipe};
//!
//! /// Resilient propagation (Riedmiller and Braun 1993): the sign of the gradient decides, each weight has its own step.
//! struct Rprop {
//!     epochs: u64,
//! }
//!
//! impl Trainer for Rprop {
//!     fn name(&self) -> &str {
//!         "rprop"
//!     }
//!
//!     fn resume(
//!         &self,
//!         network: &mut Network,
//!         data: &Data,
//!         state: Option<TrainerState>,
//!         observer: &mut dyn Observer,
//!     ) -> Result<TrainingReport, TrainingError> {
//!         let mut objective = Objective::new(network, data)?;
//!         let count = network.weights().len();
//!         let mut state = state.unwrap_or_else(|| {
//!             let state = TrainerState::new("rprop", network.weights().to_vec());
//!             state.with("steps", &vec![0.05; count]).with("signs", &vec![0.0; count])
//!         });
//!         state.check("rprop", network)?;
//!         let mut termination = TerminationReason::EpochLimit;
//!         while state.epoch() < self.epochs {
//!             let (_, gradient) = objective.error_and_gradient(state.weights())?;
//!             let mut weights = state.weights().to_vec();
//!             let (mut steps, mut signs) = (state.vector("steps", count)?.to_vec(), state.vector("signs", count)?.to_vec());
//!             for k in 0..count {
//!                 let agrees = signs[k] * gradient[k];
//!                 steps[k] = (steps[k] * if agrees < 0.0 { 0.5 } else { 1.2 }).clamp(1e-6, 1.0);
//!                 signs[k] = if agrees < 0.0 { 0.0 } else { gradient[k].signum() };
//!                 weights[k] -= steps[k] * signs[k];
//!             }
//!             let error = objective.error(&weights)?;
//!             state.set("steps", &steps);
//!             state.set("signs", &signs);
//!             state.note_epoch(&weights, error);
//!             let to_go_on_from = || state.clone();
//!             let progress = Progress::new(state.epoch(), self.epochs, error, &to_go_on_from);
//!             if observer.progress(&progress) == Control::Stop {
//!                 termination = TerminationReason::Stopped;
//!                 break;
//!             }
//!         }
//!         let error = objective.error(state.weights())?;
//!         network.weights_mut().copy_from_slice(state.weights());
//!         Ok(TrainingReport::new(state, error, termination))
//!     }
//! }
//!
//! let x: Vec<f64> = (0..30).map(|k| k as f64 / 29.0).collect();
//! let y = x.iter().map(|x| 2.0 * x * x).collect();
//! let recipe = Recipe::new(vec![Column::new("x", "1")], Column::new("y", "1"), vec![6]);
//! let (model, report) = Model::fit(&recipe, &Data::new(x, 1, y)?, &Rprop { epochs: 300 }, &mut Silent)?;
//! assert!((model.value(&[0.5])? - 0.5).abs() < 0.02 && report.trainer == "rprop");
//! assert_eq!(model.provenance().trainer, "rprop");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod levenberg_marquardt;
mod registry;
mod state;
mod traingdx;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::data::Data;
use crate::network::Network;

pub use error::{TerminationReason, TrainingError};
pub use levenberg_marquardt::{LevenbergMarquardt, Regularisation};
pub use registry::{ALL, NAMES, Options, TrainerKind, by_name};
pub use state::{HistoryPoint, TrainerState};
pub use traingdx::Traingdx;

/// An algorithm that trains a network; the documentation of [this module](self) contains a user-defined example.
pub trait Trainer: Send + Sync {
    /// Name of the trainer in commands and records.
    fn name(&self) -> &str;

    /// Trains from the given state, or from the current weights of the network if there is none. The data are in the
    /// scaled units of the network. The result of a resumed training is identical bit by bit to that of an uninterrupted
    /// training.
    ///
    /// # Errors
    /// If data or state do not match the network, or if the memory does not suffice.
    fn resume(
        &self,
        network: &mut Network,
        data: &Data,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError>;

    /// Trains from the current weights of the network.
    ///
    /// # Errors
    /// As [`Trainer::resume`].
    fn train(
        &self,
        network: &mut Network,
        data: &Data,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError> {
        self.resume(network, data, None, observer)
    }

    /// The same trainer with those of the given options that it supports; `None` if it supports none. A study that trains
    /// several kinds of networks adapts its trainer by this method.
    fn adapted(&self, _options: &Options) -> Option<SharedTrainer> {
        None
    }
}

/// A trainer that is shared between the parts of a study.
///
/// ```
/// use granum_nets::trainer::{LevenbergMarquardt, SharedTrainer};
///
/// let trainer = SharedTrainer::from(LevenbergMarquardt { epochs: 50, ..Default::default() });
/// assert_eq!(trainer.name(), "levenberg-marquardt");
/// ```
#[derive(Clone)]
pub struct SharedTrainer(Arc<dyn Trainer>);

impl<T: Trainer + 'static> From<T> for SharedTrainer {
    fn from(trainer: T) -> SharedTrainer {
        SharedTrainer(Arc::new(trainer))
    }
}

impl std::ops::Deref for SharedTrainer {
    type Target = dyn Trainer;
    fn deref(&self) -> &(dyn Trainer + 'static) {
        self.0.as_ref()
    }
}

impl AsRef<dyn Trainer> for SharedTrainer {
    fn as_ref(&self) -> &(dyn Trainer + 'static) {
        self.0.as_ref()
    }
}

impl std::fmt::Debug for SharedTrainer {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_tuple("SharedTrainer").field(&self.name()).finish()
    }
}

impl Default for SharedTrainer {
    /// Levenberg-Marquardt with Bayesian regularisation.
    fn default() -> SharedTrainer {
        LevenbergMarquardt::default().into()
    }
}

/// The decision of an observer whether training continues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Continue training.
    Continue,
    /// Stop after this epoch: the network keeps its current weights, and the report contains the state from which training
    /// can be resumed.
    Stop,
}

/// The progress of training.
pub struct Progress<'a> {
    /// Number of completed epochs (for `traingdx` including rejected steps, as in the toolbox).
    pub epoch: u64,
    /// Largest number of epochs.
    pub epochs: u64,
    /// Mean squared error over the training rows, in scaled units.
    pub error: f64,
    /// Mean squared error over the validation rows, if there are any.
    pub validation_error: Option<f64>,
    state: &'a dyn Fn() -> TrainerState,
}

impl<'a> Progress<'a> {
    /// The progress after an epoch, with a function that returns the state for resuming.
    pub fn new(epoch: u64, epochs: u64, error: f64, state: &'a dyn Fn() -> TrainerState) -> Progress<'a> {
        Progress { epoch, epochs, error, validation_error: None, state }
    }

    /// The state from which training can be resumed with bit-identical results, see [`Trainer::resume`].
    pub fn state(&self) -> TrainerState {
        (self.state)()
    }
}

/// An observer of the progress of training. It can stop the training, but cannot change the result in any other way.
///
/// ```
/// use granum_nets::trainer::{Control, LevenbergMarquardt, Progress, Trainer};
/// use granum_nets::{Data, Network};
///
/// let data = Data::new(vec![0.0, 0.5, 1.0], 1, vec![0.2, 0.4, 0.8])?;
/// let mut network = Network::new(&[1, 3, 1], 1)?;
/// // A closure is an observer; this one stops after the second epoch.
/// let mut stop = |p: &Progress| if p.epoch < 2 { Control::Continue } else { Control::Stop };
/// let report = LevenbergMarquardt::default().train(&mut network, &data, &mut stop)?;
/// assert_eq!(report.epochs, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Observer {
    /// Called after every epoch.
    fn progress(&mut self, progress: &Progress) -> Control;
}

/// An observer that does nothing.
pub struct Silent;

impl Observer for Silent {
    fn progress(&mut self, _: &Progress) -> Control {
        Control::Continue
    }
}

impl<F: FnMut(&Progress) -> Control> Observer for F {
    fn progress(&mut self, progress: &Progress) -> Control {
        self(progress)
    }
}

/// The result of Bayesian regularisation (MacKay 1992; Foresee and Hagan 1997), in scaled units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// Precision of the weights: `1 / alpha` is their prior variance.
    pub alpha: f64,
    /// Precision of the targets: `1 / beta` is the variance of the noise.
    pub beta: f64,
    /// Effective number of parameters.
    pub gamma: f64,
}

/// The report of a training.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TrainingReport {
    /// Name of the trainer.
    pub trainer: String,
    /// Number of epochs.
    pub epochs: u64,
    /// Mean squared error over the training rows in scaled units, at the end.
    pub error: f64,
    /// Mean squared error over the validation rows in scaled units, at the end.
    pub validation_error: Option<f64>,
    /// The history of the error, thinned to at most 1024 points.
    pub history: Vec<HistoryPoint>,
    /// Reason why the training ended.
    pub termination: TerminationReason,
    /// The result of Bayesian regularisation, if the trainer uses it.
    pub evidence: Option<Evidence>,
    /// Errors (output minus target, in scaled units) that the observations of each block would have, to first order, if
    /// the block had not been used for training; available if the trainer computes them and there are two or more blocks.
    pub left_out: Option<Vec<f64>>,
    /// Wall time, s; 0 if the trainer did not measure it. It must not enter a hash of the result.
    pub seconds: f64,
    /// The state from which training can be resumed, see [`Trainer::resume`].
    pub state: TrainerState,
}

impl TrainingReport {
    /// The report of a training that ended in a state with the given mean squared error, without the optional parts.
    pub fn new(state: TrainerState, error: f64, termination: TerminationReason) -> TrainingReport {
        TrainingReport {
            trainer: state.trainer().to_string(),
            epochs: state.epoch(),
            error,
            validation_error: None,
            history: state.history().to_vec(),
            termination,
            evidence: None,
            left_out: None,
            seconds: 0.0,
            state,
        }
    }
}

/// Refuses data whose numbers of columns do not match the network.
pub(crate) fn check_columns(network: &Network, data: &Data) -> Result<(), TrainingError> {
    if (network.inputs(), network.outputs()) == (data.input_columns(), data.target_columns()) {
        return Ok(());
    }
    Err(TrainingError::Columns {
        inputs: network.inputs(),
        outputs: network.outputs(),
        columns: data.input_columns(),
        targets: data.target_columns(),
    })
}

#[cfg(test)]
mod tests;
