//! Many steps in short slices, between which an observer is told of the work and can stop it. The bits of the result do not depend on
//! the slices.

use crate::loading::measure::MeasureGoal;
use crate::observer::{Flow, SimulationObserver, SimulationProgress, Work};
use crate::simulation::Simulation;
use crate::simulation_error::SimulationError;

/// Advances by `steps` steps, or to the first step at which one of the goals is reached, unless the observer stops it before. The
/// observer is not called after the last step. `progress` describes a state.
///
/// # Errors
/// As for [`Simulation::advance`].
pub(crate) fn advance(
    simulation: &mut Simulation,
    goals: &[MeasureGoal],
    steps: u64,
    observer: &mut dyn SimulationObserver,
    progress: impl for<'a> Fn(&'a Simulation) -> SimulationProgress<'a>,
) -> Result<Flow, SimulationError> {
    let end = simulation.state().step().saturating_add(steps);
    loop {
        let state = simulation.state();
        let left = end.saturating_sub(state.step());
        let slice = (observer.work_every() / state.grains().max(1) as u64).clamp(1, left.max(1));
        simulation.advance_to(goals, slice.min(left))?;
        let state = simulation.state();
        let arrived = state.step() >= end;
        if arrived || has_come(goals, simulation) {
            return Ok(Flow::Continue);
        }
        if observer.work(&Work::Steps(&progress(simulation))) == Flow::Stop {
            return Ok(Flow::Stop);
        }
    }
}

/// True if one of the goals is reached.
pub(crate) fn has_come(goals: &[MeasureGoal], simulation: &Simulation) -> bool {
    let here = simulation.state().macro_state();
    goals.iter().any(|goal| goal.has_come(&here))
}
