//! The trait of trainers, and trainers that are shared.

use std::sync::Arc;

use super::error::TrainingError;
use super::observer::Observer;
use super::options::Options;
use super::report::TrainingReport;
use super::state::TrainerState;
use crate::data::Data;
use crate::network::Network;

/// An algorithm that trains a network; the documentation of [this module](super) contains a user-defined example.
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
