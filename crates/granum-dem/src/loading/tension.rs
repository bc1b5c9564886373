//! The tensile strength of a sample, where a stage asks for more tension than it can carry.
//!
//! A stress that is to become negative falls until contacts break, and rises again towards zero while the sample goes on being
//! stretched. Its lowest value is the tensile strength along this path: that is the result of the stage, which ends there. A sample
//! without adhesion has none.
//!
//! The lowest value is followed in every step, by goals that lie half a per cent below the one before, and noted at these and at the
//! checks only, so that it does not depend on when the stage is looked at. It is known to half a per cent.

use serde::{Deserialize, Serialize};

use super::measure::{MacroState, Measure, MeasureGoal};
use super::reference_stress::CARRIES_NOTHING;
use super::until::{Reason, Until};
use crate::invariants;
use crate::servo::{CellControl, Row};
use crate::state::State;

/// Number of steps between two checks.
const CHECK_EVERY: u64 = 500;
/// Number of checks in a row that must find less than half of the largest tension.
const CHECKS_TO_CONVERGE: u32 = 3;
/// Share of the largest tension below which the sample is torn, and of the tension asked for that must be missing.
const HALF: f64 = 0.5;
/// Distance between two successive goals, over the value.
const RESOLUTION: f64 = 0.005;
/// Share of the stress at the start below which a negative target is a rounding error.
const ROUNDING: f64 = 1e-9;

/// A stress that a stage brings into tension.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tension {
    /// The stress.
    measure: Measure,
    /// Its lowest value since the start of the stage, Pa; never positive.
    lowest: f64,
    /// Stress at the start of the stage, Pa, a thousandth of which counts as nothing.
    scale: f64,
    /// Number of successive checks that found the sample torn.
    torn_checks: u32,
    /// Step of the last of these checks.
    looked_at: u64,
}

impl Tension {
    /// The tension for which a stage asks, if it does: by the end of a controlled stress, or by an end condition. `ramp` is the duration of
    /// its ramps at full rate, s.
    pub(super) fn asked_for(
        ends: &[Until],
        control: &CellControl,
        ramp: Option<f64>,
        state: &State,
    ) -> Option<Tension> {
        let start = state.macro_state();
        let began = invariants::mean(&start.stress).abs();
        // A stress that moves without a ramp has no end of its own.
        let elapsed = ramp.unwrap_or(1e300);
        let is_tension = |row: &Row| row.aim(elapsed) < -ROUNDING * began;
        let single = |k: usize| control.rows().any(|row| row.single() == Some(k) && is_tension(row));
        let mean = control.rows().any(|row| row.is_mean() && is_tension(row)) || (0..3).all(single);
        let of_control = match mean {
            true => Some(Measure::MeanStress),
            false => (0..3).find(|k| single(*k)).map(|k| Measure::Stress(k as u8)),
        };
        let of_end = || {
            ends.iter().find_map(|until| match *until {
                Until::Reaches {
                    measure: measure @ (Measure::MeanStress | Measure::Stress(0..=2)),
                    value,
                } if value < 0.0 && measure.value(&start) > value => Some(measure),
                _ => None,
            })
        };
        let measure = of_control.or_else(of_end)?;
        let scale = began.max(state.contact_stress());
        Some(Tension { measure, lowest: 0.0, scale, torn_checks: 0, looked_at: 0 })
    }

    /// Stress below which nothing is carried, Pa.
    fn nothing(&self) -> f64 {
        CARRIES_NOTHING * self.scale
    }

    /// The value at which the stress is noted next.
    pub(super) fn goal(&self) -> MeasureGoal {
        let next = self.lowest.min(-self.nothing());
        MeasureGoal { measure: self.measure, origin: 0.0, value: (1.0 + RESOLUTION) * next, rising: false }
    }

    /// Notes the present state; the reason for the end of the stage if the sample is torn. `steps` have been made since its start.
    pub(super) fn note(&mut self, state: &State, steps: u64) -> Option<Reason> {
        let macro_state = state.macro_state();
        let is_check = steps > 0 && steps.is_multiple_of(CHECK_EVERY) && state.step() != self.looked_at;
        // A state that is looked at for another reason, as one that is recorded, must not decide.
        if is_check || self.goal().has_come(&macro_state) {
            self.lowest = self.lowest.min(self.measure.value(&macro_state));
        }
        if is_check {
            self.looked_at = state.step();
            let is_empty = state.contact_stress() <= self.nothing();
            self.torn_checks = match self.is_torn(state, &macro_state, is_empty) {
                true if is_empty => CHECKS_TO_CONVERGE,
                true => self.torn_checks + 1,
                false => 0,
            };
        }
        let strength = -self.lowest + 0.0;
        (self.torn_checks >= CHECKS_TO_CONVERGE)
            .then_some(Reason::TensileStrength { measure: self.measure, strength })
    }

    /// True if less than half of the largest tension is left, although the stage asks for more.
    fn is_torn(&self, state: &State, macro_state: &MacroState, is_empty: bool) -> bool {
        let now = self.measure.value(macro_state);
        let is_missed = self.aim(state).is_none_or(|aim| aim < 0.0 && now - aim >= -HALF * aim);
        let has_fallen = now <= self.nothing() && now >= HALF * self.lowest;
        let was_carried = self.lowest < -self.nothing();
        is_missed && has_fallen && (was_carried || is_empty)
    }

    /// The present target of the stress, Pa, if it is controlled.
    fn aim(&self, state: &State) -> Option<f64> {
        let control = state.control();
        match self.measure {
            Measure::Stress(k) => {
                let elapsed = control.progress(state.time());
                control.rows().find(|row| row.single() == Some(usize::from(k))).map(|row| row.aim(elapsed))
            }
            _ => control.target_mean_stress(state.time()),
        }
    }
}
