//! One observation of an assembly: the assembly and the quantities that several sensors need.

use std::sync::{LazyLock, OnceLock};

use granum_core::assembly::{Assembly, Contact};
use granum_dem::config::Recording;

use crate::pairs::{Pair, Pairs};
use crate::ratio::mean;
use crate::stress_tensor::Stress;

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
    /// The pairs of bodies that touch, found where a sensor asks for them.
    pairs: OnceLock<Pairs>,
}

/// The recording of an observation without one of its own.
static USUAL: LazyLock<Recording> = LazyLock::new(Recording::default);

impl<'a> Observation<'a> {
    /// Observes an assembly.
    pub fn new(assembly: &'a Assembly) -> Self {
        let sum: f64 = assembly.contacts.iter().map(|contact| contact.normal_force).sum();
        let (mean_normal_force, volume) = (mean(sum, assembly.contacts.len()), assembly.volume());
        let stress = Stress::from_assembly(assembly, mean_normal_force, volume);
        Observation { assembly, mean_normal_force, volume, stress, recording: &USUAL, pairs: OnceLock::new() }
    }

    /// The same observation as part of a recording, which has the parameters of sensors.
    pub fn with_recording(self, recording: &'a Recording) -> Self {
        Observation { recording, ..self }
    }

    /// The pairs of bodies that touch, in the order of their indices.
    pub fn pairs(&self) -> impl Iterator<Item = Pair<'_>> {
        self.pairs.get_or_init(|| Pairs::from_assembly(self.assembly)).each(self.assembly)
    }

    /// True for a contact of the strong network: `N > <N>` (Radjai et al. 1998).
    #[inline]
    pub fn is_strong(&self, contact: &Contact) -> bool {
        contact.normal_force > self.mean_normal_force
    }
}
