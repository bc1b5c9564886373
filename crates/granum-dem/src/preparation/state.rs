//! The progress of a preparation, which can be saved at any check.

use serde::{Deserialize, Serialize};

use super::{Procedure, Trial};
use crate::loading::StageProgress;
use crate::observer::{Phase, SimulationProgress};
use crate::simulation::Simulation;

/// The progress of a preparation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PreparationState {
    /// Completed trials.
    pub(super) trials: Vec<Trial>,
    /// Number of steps of completed phases.
    pub(super) steps: u64,
    /// Simulated time of completed phases, s.
    #[serde(default)]
    pub(super) time: f64,
    /// The procedure of this trial; `None` where a packing is only brought to rest.
    pub(super) procedure: Option<Procedure>,
    /// Its position in the search.
    pub(super) position: f64,
    pub(super) stage: PhaseState,
    /// Number of checks in a row that found the goal of the phase reached.
    pub(super) converged_checks: u32,
    /// True if it started from a packing instead of random insertion.
    #[serde(default)]
    pub(super) packing: bool,
}

/// A phase, with its run state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) enum PhaseState {
    /// Isotropic compression.
    Compaction {
        /// Rate limit once load is carried, 1/s.
        slow: f64,
        /// Largest number of steps.
        limit: u64,
        /// True once load is carried.
        loaded: bool,
    },
    /// Relaxation to equilibrium.
    Relaxation,
    /// Relaxation to equilibrium at another mean stress.
    Consolidation {
        /// Largest number of steps.
        limit: u64,
    },
    /// Strain cycles, or a stage of the specification.
    Loading {
        /// Its index among the stages of the trial.
        index: usize,
        /// Its run state.
        progress: Box<StageProgress>,
    },
    /// A trial that is made denser by lowering the friction.
    Densification {
        /// The present coefficient of friction.
        friction: f64,
        /// Number of checks so far.
        checks: u32,
        /// What is sought.
        aim: Aim,
    },
    /// The same by strain cycles without friction.
    DensifyingCycles {
        /// Volumetric strain at which they end.
        strain: f64,
        /// What is sought.
        aim: Aim,
        /// Their run state.
        progress: Box<StageProgress>,
    },
    /// Relaxation of a trial that was made denser.
    Densified {
        /// Where the densification stopped.
        aim: Aim,
    },
}

/// The aim of a densification.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Aim {
    /// Solid fraction at which it ends; afterwards that at which it ended.
    pub solid_fraction: f64,
    /// Number of the round, from 1.
    pub round: u32,
    /// Solid fraction of the trial before the first round.
    pub before: f64,
}

impl PreparationState {
    /// The phase.
    pub fn phase(&self) -> Phase {
        match self.stage {
            PhaseState::Compaction { .. } | PhaseState::Densification { .. } => Phase::Compaction,
            PhaseState::Relaxation | PhaseState::Densified { .. } => Phase::Relaxation,
            PhaseState::DensifyingCycles { .. } => Phase::Cycles,
            PhaseState::Consolidation { .. } => Phase::Consolidation,
            PhaseState::Loading { index, .. } => self.phase_of_stage(index),
        }
    }

    /// The procedure of the compaction; `None` where nothing is compacted.
    pub fn procedure(&self) -> Option<Procedure> {
        self.procedure
    }

    /// Number of the present trial of the search, from 1.
    pub fn trial(&self) -> usize {
        self.trials.len() + 1
    }

    /// Number of steps of the completed phases, in all trials.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The progress as observers see it.
    pub(super) fn progress<'a>(&self, simulation: &'a Simulation) -> SimulationProgress<'a> {
        let state = simulation.state();
        let steps = self.steps.saturating_add(state.step());
        let time = self.time + state.time();
        SimulationProgress {
            trial: self.trial(),
            ..SimulationProgress::new(self.phase(), steps, time, simulation)
        }
    }

    /// Adds the steps and the time of a phase that is complete.
    pub(super) fn count(&mut self, simulation: &Simulation) {
        self.steps += simulation.state().step();
        self.time += simulation.state().time();
        self.converged_checks = 0;
    }
}
