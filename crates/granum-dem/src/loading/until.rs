//! The end of a stage: its end conditions, of which the first that is met counts, and the reason to be reported.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::measure::Measure;

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
    /// cent of p of its target. Where the target is zero it is half a per cent of p at the start of the stage, and a sample that
    /// carries nothing is at rest.
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

impl Until {
    /// True if both ask for the same: the same condition, and of a measure the same measure.
    pub fn is_of_kind(&self, other: &Until) -> bool {
        match (self, other) {
            (Until::Reaches { measure: one, .. }, Until::Reaches { measure: another, .. })
            | (
                Until::DoubleAmplitude { measure: one, .. },
                Until::DoubleAmplitude { measure: another, .. },
            ) => one == another,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }
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
    /// The stage asks for more tension than the sample can carry: this is its tensile strength.
    TensileStrength {
        /// The stress in tension: the mean stress, or a component.
        measure: Measure,
        /// The largest tension of the stage, Pa, positive; zero where no grains hold each other.
        strength: f64,
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
    /// True if one of the requested end conditions was met, or the strength of the sample is the result.
    pub fn is_asked_for(&self) -> bool {
        matches!(self, Reason::End(_) | Reason::TensileStrength { .. })
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
            Reason::TensileStrength { measure, strength } => write!(
                f,
                "tensile strength reached: {} fell to {:.4e} Pa and no farther, although the stage asks for more tension",
                measure.name(),
                -strength + 0.0
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
