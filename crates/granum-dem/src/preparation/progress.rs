//! The phases of a run, and what a preparation gives.

use serde::{Deserialize, Serialize};

use crate::simulation::Simulation;

/// Which part of a preparation or test runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Isotropic compression.
    Compaction,
    /// Coming to rest with the final properties.
    Relaxation,
    /// Isotropic compression or unloading of a sample to another mean stress.
    Consolidation,
    /// The loading path.
    Shear,
}

impl Phase {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Compaction => "compaction",
            Phase::Relaxation => "relaxation",
            Phase::Consolidation => "consolidation",
            Phase::Shear => "shear",
        }
    }
}

/// One trial of the preparation friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Coefficient of friction while compacting.
    pub friction: f64,
    /// Solid fraction that came of it.
    pub solid_fraction: f64,
}

/// A sample and how it was come by.
pub struct Sample {
    /// The simulation, at rest at the target stress with the final properties.
    pub simulation: Simulation,
    /// Every trial of the preparation friction; the last one made the sample.
    pub trials: Vec<Trial>,
    /// Steps of all trials together.
    pub steps: u64,
    /// Simulated time of all trials together, s.
    pub time: f64,
    /// Unbalanced force at the end.
    pub unbalanced_force: f64,
    /// True if the unbalanced force and the stress came within their bounds before the limit of steps.
    pub settled: bool,
    /// True if the target solid fraction was met (also when none was asked for).
    pub solid_fraction_met: bool,
}
