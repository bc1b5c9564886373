//! One observation of an assembly: the assembly and the quantities that several sensors need.

use std::sync::LazyLock;

use granum_core::assembly::{Assembly, Contact};
use granum_dem::config::Recording;

use crate::stress::Stress;

/// An assembly with its volume, its mean normal force, which separates strong from weak contacts, and its stress.
pub struct Observation<'a> {
    /// The observed assembly.
    pub assembly: &'a Assembly,
    /// Mean `<N>` of the elastic normal forces of all contacts, tension negative, N; 0 without contacts.
    pub mean_normal_force: f64,
    /// Volume of the cell, m3.
    pub volume: f64,
    /// Stress.
    pub stress: Stress,
    /// The recording of the observation, with the parameters of sensors.
    pub recording: &'a Recording,
}

/// The recording of an observation without one of its own.
static USUAL: LazyLock<Recording> = LazyLock::new(Recording::default);

impl<'a> Observation<'a> {
    /// Observes an assembly.
    pub fn new(assembly: &'a Assembly) -> Self {
        let sum: f64 = assembly.contacts.iter().map(|contact| contact.normal_force).sum();
        let mut observation = Observation {
            assembly,
            mean_normal_force: mean(sum, assembly.contacts.len()),
            volume: assembly.volume(),
            stress: Stress::default(),
            recording: &USUAL,
        };
        observation.stress = Stress::of(&observation);
        observation
    }

    /// The same observation as part of a recording, which has the parameters of sensors.
    pub fn with_recording(self, recording: &'a Recording) -> Self {
        Observation { recording, ..self }
    }

    /// True for a contact of the strong network: `N > <N>` (Radjai et al. 1998).
    #[inline]
    pub fn is_strong(&self, contact: &Contact) -> bool {
        contact.normal_force > self.mean_normal_force
    }
}

/// `sum / count`, and 0 if the count is 0.
pub(crate) fn mean(sum: f64, count: usize) -> f64 {
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// `part / whole`, and 0 if the whole is 0.
pub(crate) fn ratio(part: f64, whole: f64) -> f64 {
    if whole == 0.0 { 0.0 } else { part / whole }
}
