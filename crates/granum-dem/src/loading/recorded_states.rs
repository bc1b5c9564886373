//! The states of a stage that are recorded.

use serde::{Deserialize, Serialize};

use super::measure::Measure;
use crate::config::Spacing;

/// The states of a stage that are recorded, by a measure. State 0 is the start of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordedStates {
    /// The measure by which states are spaced; it should increase along the stage.
    pub measure: Measure,
    /// Number of equal intervals; not used with [`Spacing::Strains`] and [`Spacing::Every`].
    pub states: usize,
    /// The spacing of the states.
    pub spacing: Spacing,
    /// Value of the measure at the last state; infinite if states are recorded up to the end of the stage.
    #[serde(with = "end")]
    pub end: f64,
}

impl Default for RecordedStates {
    /// Only the start of the stage.
    fn default() -> Self {
        RecordedStates {
            measure: Measure::ArcLength,
            states: 0,
            spacing: Spacing::Strains(Vec::new()),
            end: f64::INFINITY,
        }
    }
}

impl RecordedStates {
    /// States at equal intervals of a measure up to an end.
    pub fn equal(measure: Measure, states: usize, end: f64) -> RecordedStates {
        RecordedStates { measure, states, spacing: Spacing::Equal, end }
    }

    /// A state at every interval of a measure, until the stage ends. The shortest interval is 1e-12, which replaces an interval of
    /// zero.
    pub fn every(measure: Measure, interval: f64) -> RecordedStates {
        let interval = interval.max(1e-12);
        RecordedStates { measure, states: 0, spacing: Spacing::Every(interval), end: f64::INFINITY }
    }
}

/// JSON has no infinity.
mod end {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(end: &f64, to: S) -> Result<S::Ok, S::Error> {
        end.is_finite().then_some(*end).serialize(to)
    }

    pub(super) fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::INFINITY))
    }
}
