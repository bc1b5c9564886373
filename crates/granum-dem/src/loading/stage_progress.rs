//! The progress of a stage: how far its end conditions are.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::measure::{MacroState, Measure, MeasureGoal};
use super::tension::Tension;
use super::until::{Reason, Until};
use super::zero_stress;
use crate::invariants;
use crate::simulation::Simulation;
use crate::state::State;

/// Number of steps between two checks for equilibrium.
pub(super) const REST_EVERY: u64 = 500;
/// Number of checks in a row that must find equilibrium.
const CHECKS_TO_CONVERGE: u32 = 3;
/// Number of intervals into which the window of a critical state is divided by the measurements.
const PARTS: usize = 20;
/// Fraction of the initial mean stress below which a stage with controlled stresses ends because the sample is unjammed.
const UNJAMMED: f64 = 1e-3;

/// The run state of the end conditions of a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageProgress {
    /// Stress, strain and time at the start of the stage.
    pub start: MacroState,
    /// Step number at the start.
    pub start_step: u64,
    /// Number of reversals of the stage.
    pub reversals: u64,
    /// Stress, strain and time at the last reversal.
    #[serde(default)]
    turned: Option<MacroState>,
    /// Duration of the ramps of the stage, s.
    #[serde(default)]
    pub(super) ramp: Option<f64>,
    /// Number of successive checks that found equilibrium.
    converged_checks: u32,
    /// Step of the last of these checks.
    looked_at: u64,
    /// Stress ratio and volumetric strain at equal intervals of arc length, over the last window.
    history: VecDeque<[f64; 2]>,
    /// Number of measurements made for that.
    marked: u64,
    /// The tension that the stage asks for.
    pub(super) tension: Option<Tension>,
}

impl StageProgress {
    /// The state at the start of a stage.
    pub(super) fn begin(simulation: &Simulation) -> StageProgress {
        let state = simulation.state();
        StageProgress { start: state.macro_state(), start_step: state.step(), ..StageProgress::default() }
    }

    /// Registers a reversal of the stage.
    pub(super) fn turn(&mut self, state: &State) {
        self.reversals += 1;
        self.turned = Some(state.macro_state());
    }

    /// The value from which a measure is counted.
    pub fn origin(&self, measure: Measure) -> f64 {
        if measure.counts_from_stage() { measure.value(&self.start) } else { 0.0 }
    }

    /// Checks the end conditions on a state and updates their run state; returns the reason if one is met.
    pub(super) fn check(&mut self, ends: &[Until], state: &State) -> Option<Reason> {
        let macro_state = state.macro_state();
        let mut reason = None;
        for until in ends {
            let came = match *until {
                Until::Reaches { measure, value } => self.goal(measure, value).has_come(&macro_state),
                Until::Reversals(count) => self.reversals >= count,
                Until::RampOver => self.ramp_end().is_none_or(|goal| goal.has_come(&macro_state)),
                Until::PorePressureRatio(ratio) => self.liquefied(ratio).has_come(&macro_state),
                Until::DoubleAmplitude { measure, value } => {
                    self.span(measure, value).iter().flatten().any(|goal| goal.has_come(&macro_state))
                }
                Until::AtRest { unbalanced_force } => self.rests(unbalanced_force, state),
                Until::CriticalState { window, stress_ratio, volumetric_strain } => {
                    self.mark(window, &macro_state);
                    self.within(0, stress_ratio) && self.within(1, volumetric_strain)
                }
            };
            if came {
                reason.get_or_insert(Reason::End(*until));
            }
        }
        reason
    }

    /// The reason for the end if stresses are controlled that the sample no longer carries. While its volume decreases it may carry
    /// them again: a loose sample that collapses is compressed until it does. A sample that bonds hold carries tension. A stage that asks for no stress goes on, or has met
    /// its end.
    pub(super) fn unjammed(&self, ends: &[Until], state: &State) -> Option<Reason> {
        let before = invariants::mean(&self.start.stress);
        let mean_stress = state.mean_stress();
        let is_controlled = state.control().rows().next().is_some();
        let lost = before > 0.0 && is_controlled && mean_stress < UNJAMMED * before;
        let volume_rate: f64 = (0..3).map(|axis| state.gradient[axis][axis]).sum();
        // Bonds carry tension, so that a mean stress of zero says nothing where they do.
        let is_held = || !state.bonds.is_empty() && state.contact_stress() >= UNJAMMED * before;
        if !lost || volume_rate < 0.0 || zero_stress::is_asked_for(state, before) || is_held() {
            return None;
        }
        let end = zero_stress::end_without_stress(ends, before).map(Reason::End);
        Some(end.unwrap_or(Reason::Unjammed { mean_stress, before }))
    }

    /// Notes the tension for which the stage asks; the reason for its end if the sample is torn.
    pub(super) fn note_tension(&mut self, state: &State) -> Option<Reason> {
        let steps = state.step() - self.start_step;
        self.tension.as_mut()?.note(state, steps)
    }

    /// The goals at which an end condition may be met.
    pub(super) fn goals(&self, ends: &[Until], into: &mut Vec<MeasureGoal>) {
        for until in ends {
            match *until {
                Until::Reaches { measure, value } => into.push(self.goal(measure, value)),
                Until::CriticalState { window, .. } => {
                    into.push(self.goal(Measure::ArcLength, self.next_mark(window)));
                }
                Until::RampOver => into.extend(self.ramp_end()),
                Until::PorePressureRatio(ratio) => into.push(self.liquefied(ratio)),
                Until::DoubleAmplitude { measure, value } => {
                    into.extend(self.span(measure, value).into_iter().flatten());
                }
                Until::Reversals(_) | Until::AtRest { .. } => {}
            }
        }
        into.extend(self.tension.as_ref().map(Tension::goal));
    }

    /// The goal that the ramps end.
    fn ramp_end(&self) -> Option<MeasureGoal> {
        self.ramp.map(|time| self.goal(Measure::Time, time))
    }

    /// The goal that the mean stress decreases by a fraction of its initial value.
    fn liquefied(&self, ratio: f64) -> MeasureGoal {
        let value = (1.0 - ratio) * invariants::mean(&self.start.stress);
        MeasureGoal { measure: Measure::MeanStress, origin: 0.0, value, rising: false }
    }

    /// The goals that a measure changes by `value` since the last reversal, in either direction.
    fn span(&self, measure: Measure, value: f64) -> Option<[MeasureGoal; 2]> {
        let origin = measure.value(self.turned.as_ref()?);
        Some([(value, true), (-value, false)].map(|(value, rising)| MeasureGoal {
            measure,
            origin,
            value,
            rising,
        }))
    }

    fn goal(&self, measure: Measure, value: f64) -> MeasureGoal {
        let origin = self.origin(measure);
        MeasureGoal { measure, origin, value, rising: value >= measure.value(&self.start) - origin }
    }

    fn rests(&mut self, unbalanced_force: f64, state: &State) -> bool {
        let steps = state.step() - self.start_step;
        if steps > 0 && steps.is_multiple_of(REST_EVERY) && state.step() != self.looked_at {
            self.looked_at = state.step();
            let rests = zero_stress::rests(state, invariants::mean(&self.start.stress), unbalanced_force);
            self.converged_checks = if rests { self.converged_checks + 1 } else { 0 };
        }
        self.converged_checks >= CHECKS_TO_CONVERGE
    }

    /// Arc length since the start at which the next measurement for the critical state is due.
    fn next_mark(&self, window: f64) -> f64 {
        self.marked as f64 * window / PARTS as f64
    }

    fn mark(&mut self, window: f64, macro_state: &MacroState) {
        let arc = macro_state.arc_length - self.start.arc_length;
        if arc < self.next_mark(window) {
            return;
        }
        self.marked += 1;
        self.history
            .push_back([Measure::StressRatio, Measure::VolumetricStrain].map(|m| m.value(macro_state)));
        if self.history.len() > PARTS + 1 {
            self.history.pop_front();
        }
    }

    fn within(&self, which: usize, band: f64) -> bool {
        let values = || self.history.iter().map(|pair| pair[which]);
        let range = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
        self.history.len() > PARTS && range < band
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checkpoint::tests::running;
    use crate::servo::{CellControl, Row};

    /// A sample that has lost its stress ends a stage, except while it is compressed, or where next to no stress is asked for.
    #[test]
    fn a_stage_goes_on_while_it_compresses_the_sample() {
        let s = running(200, 0.0);
        let mean_stress = s.state().mean_stress();
        let mut progress = StageProgress::begin(&s);
        assert!(mean_stress > 0.0 && progress.unjammed(&[], s.state()).is_none());
        // As if the sample had carried ten thousand times its stress when the stage began.
        progress.start.stress = progress.start.stress.map(|row| row.map(|stress| 1e4 * stress));
        let mut pulled = CellControl { rate_limit: 100.0, ..CellControl::fixed() };
        pulled.rows[0] = Some(Row::component(5, 0.0));
        for axis in 0..3 {
            pulled.rate[axis][axis] = -100.0;
        }
        let compressed = CellControl::isotropic(1e4 * mean_stress, 100.0);
        let unloaded = CellControl::isotropic(0.3 * mean_stress, 100.0);
        for (control, ends) in [(compressed, false), (pulled, true), (unloaded, false)] {
            let mut s = s.clone();
            s.set_control(control);
            s.advance(3).unwrap();
            assert_eq!(progress.unjammed(&[], s.state()).is_some(), ends, "{control:?}");
        }
    }
}
