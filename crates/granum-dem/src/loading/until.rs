//! The end of a stage: its end conditions, of which the first that is met counts, and the reason to be reported.

use std::collections::VecDeque;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::measure::{MacroState, Measure, MeasureGoal};
use crate::invariants;
use crate::simulation::Simulation;
use crate::state::State;

/// An end condition of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Until {
    /// A measure reaches a value, from whichever side it starts. Arc length and time count from the start of the stage.
    Reaches {
        /// The measure.
        measure: Measure,
        /// The value.
        value: f64,
    },
    /// The stage has been reversed this many times; a cycle has two reversals.
    Reversals(u64),
    /// All ramps of the stage are over.
    RampOver,
    /// The mean stress has decreased by this fraction of its value at the start of the stage: at constant volume this is the ratio
    /// `r_u = 1 - p/p_0` of the excess pore pressure of a saturated sample under constant total mean stress.
    PorePressureRatio(f64),
    /// A measure has changed by this amount since the last reversal of the stage: the double amplitude of a cycle.
    DoubleAmplitude {
        /// The measure.
        measure: Measure,
        /// The change.
        value: f64,
    },
    /// The unbalanced force is below this value in three checks in a row, with every controlled stress within half a per
    /// cent of p of its target.
    AtRest {
        /// Unbalanced force.
        unbalanced_force: f64,
    },
    /// Over an arc length of strain the ratio of the von Mises stress to p ([`Measure::StressRatio`]) and the volumetric strain stay
    /// within bands.
    CriticalState {
        /// Arc length.
        window: f64,
        /// Width of the band of q_vM/p.
        stress_ratio: f64,
        /// Width of the band of the volumetric strain.
        volumetric_strain: f64,
    },
}

/// Why a stage ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// One of its end conditions was met.
    End(Until),
    /// It reached its largest permitted length or time before any of its end conditions was met.
    TooLong {
        /// Arc length of strain since its start.
        arc_length: f64,
        /// Time since its start, s.
        time: f64,
    },
    /// The sample no longer carries stress, so that none can be controlled.
    Unjammed {
        /// Mean stress, Pa.
        mean_stress: f64,
        /// Mean stress at the start of the stage, Pa.
        before: f64,
    },
    /// Grains overlap farther than the stage allows.
    TooDeep {
        /// Largest overlap over the sum of the radii.
        overlap: f64,
        /// The largest one that is allowed.
        limit: f64,
    },
}

/// A sentence on overlaps that are too large.
pub(crate) fn overlap_text(overlap: f64, limit: f64) -> String {
    format!(
        "grains overlap by {:.1} % of the sum of their radii, more than the {:.1} % up to which the theory of small contacts is used: \
         lower the stress or raise the stiffness of the grains, or allow more by numerics.largest_overlap",
        100.0 * overlap,
        100.0 * limit
    )
}

impl Reason {
    /// True if one of the requested end conditions was met.
    pub fn is_asked_for(&self) -> bool {
        matches!(self, Reason::End(_))
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::End(until) => until.fmt(f),
            Reason::TooLong { arc_length, time } => write!(
                f,
                "none of its end conditions was met within its limits, an arc length of strain of {arc_length:.4} and \
                 {time:.3e} s"
            ),
            Reason::Unjammed { mean_stress, before } => write!(
                f,
                "the sample no longer carries stress: the mean stress fell from {before:.4e} Pa to {mean_stress:.4e} Pa, below a \
                 thousandth of it"
            ),
            Reason::TooDeep { overlap, limit } => f.write_str(&overlap_text(*overlap, *limit)),
        }
    }
}

/// The unit of a measure after a space; nothing for a pure number.
fn unit_of(measure: Measure) -> String {
    let unit = measure.unit();
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

impl fmt::Display for Until {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Until::Reaches { measure, value } => {
                write!(f, "{} reached {value}{}", measure.name(), unit_of(*measure))
            }
            Until::Reversals(count) => write!(f, "it was reversed {count} times"),
            Until::RampOver => write!(f, "its ramp is over"),
            Until::PorePressureRatio(ratio) => {
                write!(f, "the pore pressure ratio 1 - p/p_0 reached {ratio}: the sample has liquefied")
            }
            Until::DoubleAmplitude { measure, value } => {
                write!(f, "the double amplitude of {} reached {value}{}", measure.name(), unit_of(*measure))
            }
            Until::AtRest { unbalanced_force } => {
                write!(f, "the sample is at rest: the unbalanced force is below {unbalanced_force}")
            }
            Until::CriticalState { window, stress_ratio, volumetric_strain } => write!(
                f,
                "critical state: over an arc length of {window} the stress ratio changed by less than {stress_ratio} and the \
                 volumetric strain by less than {volumetric_strain}"
            ),
        }
    }
}

/// Number of steps between two checks for equilibrium.
pub(super) const REST_EVERY: u64 = 500;
/// Number of checks in a row that must find equilibrium.
const CHECKS_TO_CONVERGE: u32 = 3;
/// Number of intervals into which the window of a critical state is divided by the measurements.
const PARTS: usize = 20;
/// Largest distance of a controlled stress from its target, over p, at which a sample can be in equilibrium.
const ARRIVED: f64 = 0.005;
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
    /// them again: a loose sample that collapses is compressed until it does.
    pub(super) fn unjammed(&self, state: &State) -> Option<Reason> {
        let before = invariants::mean(&self.start.stress);
        let mean_stress = state.mean_stress();
        let lost = before > 0.0 && state.control().rows().next().is_some() && mean_stress < UNJAMMED * before;
        let volume_rate: f64 = (0..3).map(|axis| state.gradient[axis][axis]).sum();
        (lost && volume_rate >= 0.0).then_some(Reason::Unjammed { mean_stress, before })
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
            let rests = state.unbalanced_force() < unbalanced_force && state.largest_stress_error() < ARRIVED;
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
    use crate::servo::CellControl;

    /// A sample that has lost its stress ends a stage, except while it is compressed.
    #[test]
    fn a_stage_goes_on_while_it_compresses_the_sample() {
        let s = running(200, 0.0);
        let mean_stress = s.state().mean_stress();
        let mut progress = StageProgress::begin(&s);
        assert!(mean_stress > 0.0 && progress.unjammed(s.state()).is_none());
        // As if the sample had carried ten thousand times its stress when the stage began.
        progress.start.stress = progress.start.stress.map(|row| row.map(|stress| 1e4 * stress));
        for (share, ends) in [(3.0, false), (0.3, true)] {
            let mut s = s.clone();
            s.set_control(CellControl::isotropic(share * mean_stress, 100.0));
            s.advance(3).unwrap();
            assert_eq!(progress.unjammed(s.state()).is_some(), ends, "{share} times the stress");
        }
    }
}
