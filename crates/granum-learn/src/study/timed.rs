//! Measures the training times of networks while others keep them.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use granum_nets::Model;
use granum_nets::trainer::TrainerState;

use crate::methods::networks::{NetworkCheckpoints, networks_of};
use crate::surrogate::Surrogate;

/// Notes the time of every network that is trained or found.
pub(super) struct Timed<'a> {
    checkpoints: &'a dyn NetworkCheckpoints,
    seconds: Mutex<BTreeMap<String, f64>>,
}

impl<'a> Timed<'a> {
    pub fn new(checkpoints: &'a dyn NetworkCheckpoints) -> Timed<'a> {
        Timed { checkpoints, seconds: Mutex::default() }
    }

    /// Notes the times of the networks of a surrogate that was found finished.
    pub fn found(&self, member: &str, surrogate: &dyn Surrogate) {
        let count =
            networks_of(surrogate).map_or(surrogate.columns().outputs.len(), |all| all.networks().len());
        (1..=count).for_each(|k| self.note(&format!("{member}-{k}"), 0.0));
    }

    fn note(&self, network: &str, seconds: f64) {
        let known =
            Some(seconds).filter(|seconds| *seconds > 0.0).or_else(|| self.checkpoints.seconds(network));
        if let Some(seconds) = known {
            let mut all = self.seconds.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(network.to_owned(), seconds);
        }
    }

    pub fn into_seconds(self) -> BTreeMap<String, f64> {
        self.seconds.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl NetworkCheckpoints for Timed<'_> {
    fn finished(&self, network: &str) -> Option<Model> {
        self.checkpoints.finished(network)
    }
    fn trained(&self, network: &str, model: &Model, seconds: f64) {
        self.note(network, seconds);
        self.checkpoints.trained(network, model, seconds);
    }
    fn keeps_state(&self, network: &str) -> bool {
        self.checkpoints.keeps_state(network)
    }
    fn under_way(&self, network: &str, key: &str, state: &TrainerState) {
        self.checkpoints.under_way(network, key, state);
    }
    fn state(&self, network: &str, key: &str) -> Option<TrainerState> {
        self.checkpoints.state(network, key)
    }
    fn seconds(&self, network: &str) -> Option<f64> {
        self.checkpoints.seconds(network)
    }
}
