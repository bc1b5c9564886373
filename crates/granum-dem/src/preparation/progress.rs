//! The result of a preparation.

use serde::{Deserialize, Serialize};

use crate::simulation::Simulation;

/// One trial of the search for the procedure that gives a target solid fraction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Position on the line of procedures, from the densest to the loosest.
    pub position: f64,
    /// Coefficient of friction during compaction.
    pub friction: f64,
    /// Mean stress of the compaction, Pa.
    pub mean_stress: f64,
    /// Number of cycles of axial strain after it.
    pub cycles: u64,
    /// Resulting solid fraction.
    pub solid_fraction: f64,
}

/// A sample and the record of its preparation.
pub struct Sample {
    /// The simulation, at rest at the target stress with the final properties.
    pub simulation: Simulation,
    /// All trials of the search; the last one gave the sample.
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
    /// True if the last trial was made denser than its procedure made it, up to a density that was asked for exactly.
    pub densified: bool,
}
