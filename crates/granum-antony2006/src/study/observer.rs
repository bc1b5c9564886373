//! Observers of a study.

use granum_nets::Model;
use granum_nets::trainer::TrainerState;

/// The progress of a study, reported by the thread that trains a network.
#[derive(Clone, Copy, Debug)]
pub struct StudyProgress<'a> {
    /// Name of the network: `F1-2`, or `F1-strain-only-2` for a strain-only network.
    pub network: &'a str,
    /// Number of completed epochs.
    pub epoch: u64,
    /// Largest number of epochs.
    pub epochs: u64,
    /// Mean squared error, in scaled units.
    pub error: f64,
}

/// An observer of a study, which may store its networks and may stop it. Every method has a default that does nothing.
///
/// ```
/// use std::sync::atomic::{AtomicUsize, Ordering};
///
/// use granum_antony2006::StudyObserver;
///
/// /// Counts the networks, and stops the study after the third.
/// #[derive(Default)]
/// struct Three(AtomicUsize);
///
/// impl StudyObserver for Three {
///     fn trained(&self, _network: &str, _model: &granum_nets::Model, _seconds: f64) {
///         self.0.fetch_add(1, Ordering::Relaxed);
///     }
///     fn stop(&self) -> bool {
///         self.0.load(Ordering::Relaxed) >= 3
///     }
/// }
/// assert!(!Three::default().stop());
/// ```
pub trait StudyObserver: Sync {
    /// Called after every epoch of every network.
    fn progress(&self, _progress: &StudyProgress) {}
    /// Called when the training of a network is complete, with its duration in seconds, or when a finished network was found
    /// (then the duration is 0).
    fn trained(&self, _network: &str, _model: &Model, _seconds: f64) {}
    /// Returns true if the state of an unfinished network is to be kept now. It is asked after every epoch.
    fn keeps_state(&self, _network: &str) -> bool {
        false
    }
    /// Called with the state from which the training can be resumed, at the request of [`StudyObserver::keeps_state`], and
    /// when [`StudyObserver::stop`] has ended the training; `key` identifies the training.
    fn under_way(&self, _network: &str, _key: &str, _state: &TrainerState) {}
    /// The state from which the unfinished training identified by `key` can be resumed.
    fn state(&self, _network: &str, _key: &str) -> Option<TrainerState> {
        None
    }
    /// A network of an earlier, unfinished study. It is used if it was trained on the same rows with the same size, seed,
    /// trainer and number of epochs; otherwise the network is trained again.
    fn finished(&self, _network: &str) -> Option<Model> {
        None
    }
    /// Returns true to stop the study.
    fn stop(&self) -> bool {
        false
    }
}

/// An observer that does nothing.
pub struct Silent;

impl StudyObserver for Silent {}
