//! The phases of a run, and what a preparation gives.

use serde::{Deserialize, Serialize};

use crate::simulation::Simulation;

/// The phase of a preparation or test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Isotropic compression.
    Compaction,
    /// Relaxation to equilibrium with the final properties.
    Relaxation,
    /// Isotropic compression or unloading of a sample to another mean stress.
    Consolidation,
    /// Strain cycles of a preparation.
    Cycles,
    /// The loading path.
    Shear,
}

impl Phase {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Compaction => "compaction",
            Phase::Relaxation => "relaxation",
            Phase::Consolidation => "consolidation",
            Phase::Cycles => "cycles",
            Phase::Shear => "shear",
        }
    }
}

/// One trial for the friction of the preparation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Coefficient of friction during compaction.
    pub friction: f64,
    /// Resulting solid fraction.
    pub solid_fraction: f64,
}

/// A sample and the record of its preparation.
pub struct Sample {
    /// The simulation, at rest at the target stress with the final properties.
    pub simulation: Simulation,
    /// All trials for the friction of the preparation; the last one gave the sample.
    pub trials: Vec<Trial>,
    /// Steps of all trials together.
    pub steps: u64,
    /// Simulated time of all trials together, s.
    pub time: f64,
    /// Unbalanced force at the end.
    pub unbalanced_force: f64,
    /// True if the unbalanced force and the stress came within their tolerances before the limit of steps.
    pub settled: bool,
    /// True if the target solid fraction was met, or if there was none.
    pub solid_fraction_met: bool,
}
