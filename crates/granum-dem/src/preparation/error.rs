//! Reasons why a sample cannot be prepared.

use crate::loading::{ControlError, Reason, overlap_text};
use crate::observer::Phase;
use crate::random_insertion::InsertionError;
use crate::simulation::SimulationError;

/// Reasons why a sample cannot be prepared.
#[derive(Debug, thiserror::Error)]
pub enum PreparationError {
    /// The initial state is too dense.
    #[error(transparent)]
    Insertion(#[from] InsertionError),
    /// The engine failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The observer stopped it.
    #[error("stopped during {}", phase.name())]
    Stopped {
        /// The phase in which it was stopped.
        phase: Phase,
    },
    /// The target stress was never reached.
    #[error(
        "compaction stalled after {steps} steps at p = {mean_stress:.1} Pa and solid fraction {solid_fraction:.4}, target {target} Pa; \
         the time step is {time_step:.2e} s. A lower preparation.inertial_number or a shorter numerics.time_step_factor may help; where \
         the time step is very short, so may a stiffness of the contact laws that is in proportion to the stress"
    )]
    Stalled {
        /// Steps made.
        steps: u64,
        /// Mean stress reached, Pa.
        mean_stress: f64,
        /// Solid fraction reached.
        solid_fraction: f64,
        /// Target, Pa.
        target: f64,
        /// Time step, s.
        time_step: f64,
    },
    /// Grains overlap farther than the specification allows.
    #[error(
        "in the {}, {}", phase.name(), overlap_text(*overlap, *limit)
    )]
    Overlap {
        /// The phase.
        phase: Phase,
        /// Largest overlap over the sum of the radii.
        overlap: f64,
        /// The largest one that is allowed.
        limit: f64,
    },
    /// A stage between compaction and relaxation was not executed to its end.
    #[error("stage {number} of the {count} stages of the preparation ({name}): {fault}")]
    Stage {
        /// Its number, from 1; a path may consist of several stages.
        number: usize,
        /// Number of stages.
        count: usize,
        /// Its name.
        name: String,
        /// Why.
        fault: StageFault,
    },
}

/// Reasons why a stage of a preparation cannot be executed to its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StageFault {
    /// The control is not possible.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// It ended before any of its end conditions was met, so that the sample is not the one that was asked for.
    #[error("{0}; change its end conditions, its limit most_arc_length, or the preparation before it")]
    CutShort(Reason),
    /// It starts from a saved state.
    #[error(
        "it starts from a saved state, but each stage of a preparation starts where the one before it ended"
    )]
    SavedState,
}
