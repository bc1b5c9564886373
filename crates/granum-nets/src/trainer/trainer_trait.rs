//! The trait of trainers, and trainers that are shared.

use std::sync::Arc;

use granum_core::observer::{Observer, Progress};

use super::options::Options;
use super::report::TrainingReport;
use super::state::TrainerState;
use crate::differentiable::Differentiable;
use crate::table::data::Data;
use crate::training_error::TrainingError;

/// An algorithm that trains any model that gives its error and gradient over rows or sequences; the documentation of [this module](super) contains a user-defined example.
pub trait Trainer: Send + Sync {
    /// Name of the trainer in commands and records.
    fn name(&self) -> &str;

    /// Trains from the given state, or from the current weights of the model if there is none. The data are in the
    /// scaled units of the model. The observer hears of every epoch. If it requests a stop, the model keeps its current
    /// weights, and the report contains the state from which training can be resumed. The result of a resumed training is
    /// identical bit by bit to that of an uninterrupted training.
    ///
    /// # Errors
    /// If data or state do not match the model, if the model does not provide what the trainer needs, or if the memory does
    /// not suffice.
    fn resume(
        &self,
        model: &mut dyn Differentiable,
        data: &Data,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError>;

    /// Trains from the current weights of the model.
    ///
    /// # Errors
    /// As [`Trainer::resume`].
    fn train(
        &self,
        model: &mut dyn Differentiable,
        data: &Data,
        observer: &mut dyn Observer,
    ) -> Result<TrainingReport, TrainingError> {
        self.resume(model, data, None, observer)
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

/// The progress of a training, with the mean squared errors over the training rows and the validation rows, in scaled units,
/// as its values `error` and `validation_error`.
///
/// ```
/// let progress = granum_nets::trainer::training_progress(25, 100, 1.5e-3, None);
/// assert_eq!((progress.done, progress.value("error")), (25, Some(1.5e-3)));
/// ```
pub fn training_progress(epoch: u64, epochs: u64, error: f64, validation_error: Option<f64>) -> Progress {
    let progress = Progress::new("training", "epochs", epoch).out_of(epochs).with("error", error, "");
    match validation_error {
        Some(error) => progress.with("validation_error", error, ""),
        None => progress,
    }
}
