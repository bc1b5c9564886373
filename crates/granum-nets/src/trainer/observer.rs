//! Observers of the progress of training.

use super::state::TrainerState;

/// The decision of an observer whether training continues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
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
    pub(super) state: &'a dyn Fn() -> TrainerState,
}

impl<'a> Progress<'a> {
    /// The progress after an epoch, with a function that returns the state for resuming.
    pub fn new(epoch: u64, epochs: u64, error: f64, state: &'a dyn Fn() -> TrainerState) -> Progress<'a> {
        Progress { epoch, epochs, error, validation_error: None, state }
    }

    /// The state from which training can be resumed with bit-identical results, see [`super::Trainer::resume`].
    pub fn state(&self) -> TrainerState {
        (self.state)()
    }
}

/// An observer of the progress of training. It can stop the training, but cannot change the result in any other way.
///
/// ```
/// use granum_nets::trainer::{Flow, LevenbergMarquardt, Progress, Trainer};
/// use granum_nets::{Data, Network};
///
/// let data = Data::new(vec![0.0, 0.5, 1.0], 1, vec![0.2, 0.4, 0.8])?;
/// let mut network = Network::new(&[1, 3, 1], 1)?;
/// // A closure is an observer; this one stops after the second epoch.
/// let mut stop = |p: &Progress| if p.epoch < 2 { Flow::Continue } else { Flow::Stop };
/// let report = LevenbergMarquardt::default().train(&mut network, &data, &mut stop)?;
/// assert_eq!(report.epochs, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Observer {
    /// Called after every epoch.
    fn progress(&mut self, progress: &Progress) -> Flow;
}

/// An observer that does nothing.
pub struct Silent;

impl Observer for Silent {
    fn progress(&mut self, _: &Progress) -> Flow {
        Flow::Continue
    }
}

impl<F: FnMut(&Progress) -> Flow> Observer for F {
    fn progress(&mut self, progress: &Progress) -> Flow {
        self(progress)
    }
}
