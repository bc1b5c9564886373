//! What a fit keeps of its networks while they are trained, so that it can be resumed.

use granum_nets::Model;
use granum_nets::trainer::TrainerState;

/// Keeps the networks of a fit while they are trained, each by its name. Every method has a default that keeps nothing.
pub trait NetworkCheckpoints: Sync {
    /// A network of an earlier, unfinished training. It is used if it was trained on the same rows with the same size, seed,
    /// trainer and number of epochs; otherwise the network is trained again.
    fn finished(&self, _network: &str) -> Option<Model> {
        None
    }
    /// Called when the training of a network is complete, with its duration in seconds, or when a finished network was found
    /// (then the duration is 0).
    fn trained(&self, _network: &str, _model: &Model, _seconds: f64) {}
    /// Returns true if the state of an unfinished network is to be kept now. It is asked after every epoch.
    fn keeps_state(&self, _network: &str) -> bool {
        false
    }
    /// Called with the state from which the training can be resumed, at the request of
    /// [`NetworkCheckpoints::keeps_state`], and when the training was stopped; `key` identifies the training.
    fn under_way(&self, _network: &str, _key: &str, _state: &TrainerState) {}
    /// The state from which the unfinished training identified by `key` can be resumed.
    fn state(&self, _network: &str, _key: &str) -> Option<TrainerState> {
        None
    }
    /// The time in seconds in which a network was trained, if it is known.
    fn seconds(&self, _network: &str) -> Option<f64> {
        None
    }
}

/// Keeps nothing.
pub struct NoCheckpoints;

impl NetworkCheckpoints for NoCheckpoints {}
