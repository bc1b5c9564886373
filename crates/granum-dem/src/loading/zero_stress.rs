//! Stages that bring a sample to a stress of zero, or that go on without any.
//!
//! Errors and limits in per cent of the present mean stress say nothing there: they are measured by the stress with which the stage
//! began. A sample that carries nothing has then arrived, and has not failed.

use super::measure::Measure;
use super::reference_stress::CARRIES_NOTHING;
use super::until::Until;
use crate::state::State;

/// Largest distance of a controlled stress from its target, over p, at which a sample can be in equilibrium.
const ARRIVED: f64 = 0.005;
/// Share of the mean stress at the start of a stage up to which a target counts as one of no stress.
const NEXT_TO_NOTHING: f64 = 0.05;

/// True if the control asks for no stress or for tension: by the target of the mean stress, or else by every controlled stress that
/// is no difference of others. `began` is the mean stress at the start of the stage, Pa.
pub(super) fn is_asked_for(state: &State, began: f64) -> bool {
    let limit = NEXT_TO_NOTHING * began.abs();
    if let Some(target) = state.target_mean_stress() {
        return target <= limit;
    }
    let elapsed = state.control().progress(state.time());
    let mut levels = state
        .control()
        .rows()
        .filter(|row| row.strain == [0.0; 6] && row.stress[..3].iter().sum::<f64>() != 0.0)
        .map(|row| row.aim(elapsed))
        .peekable();
    levels.peek().is_some() && levels.all(|aim| aim <= limit)
}

/// The end condition that asks for a stress of zero, or next to it, of a sample that began with this mean stress, Pa.
pub(super) fn end_without_stress(ends: &[Until], began: f64) -> Option<Until> {
    let limit = CARRIES_NOTHING * began.abs();
    ends.iter().copied().find(|until| {
        matches!(
            *until,
            Until::Reaches { measure: Measure::MeanStress | Measure::Stress(0..=2), value }
                if (0.0..=limit).contains(&value)
        )
    })
}

/// True if the sample is in equilibrium at the stresses that the control asks for. Where these are zero, a sample that carries
/// nothing is at rest whatever the few forces in it do.
pub(super) fn rests(state: &State, began: f64, unbalanced_force: f64) -> bool {
    let aimed = state.target_mean_stress().unwrap_or_else(|| state.mean_stress()).abs();
    let is_controlled = state.control().rows().next().is_some();
    if aimed > CARRIES_NOTHING * began.abs() || !is_controlled {
        return state.unbalanced_force() < unbalanced_force && state.largest_stress_error() < ARRIVED;
    }
    let carried = state.contact_stress();
    let scale = began.abs().max(carried);
    let has_arrived = state.largest_stress_distance() <= ARRIVED * scale;
    let is_empty = carried <= CARRIES_NOTHING * scale;
    has_arrived && (is_empty || state.unbalanced_force() < unbalanced_force)
}
