//! Which states of a stage are recorded.

use serde::{Deserialize, Serialize};

use super::measure::Measure;
use crate::config::Spacing;

/// Which states of a stage are recorded, by what measure. State 0 is the start of the stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// What the places of states are counted in; it should grow along the stage.
    pub measure: Measure,
    /// Number of equal intervals, of no use with [`Spacing::Strains`] and [`Spacing::Every`].
    pub states: usize,
    /// Where the states stand.
    pub spacing: Spacing,
    /// Value of the measure at the last state; infinite where states go on to the end of the stage, whenever that is.
    #[serde(with = "end")]
    pub end: f64,
}

impl Default for Record {
    /// The start of the stage alone.
    fn default() -> Self {
        Record {
            measure: Measure::ArcLength,
            states: 0,
            spacing: Spacing::Strains(Vec::new()),
            end: f64::INFINITY,
        }
    }
}

impl Record {
    /// States at equal intervals of a measure up to an end.
    pub fn equal(measure: Measure, states: usize, end: f64) -> Record {
        Record { measure, states, spacing: Spacing::Equal, end }
    }

    /// A state every so often, until the stage ends.
    pub fn every(measure: Measure, interval: f64) -> Record {
        Record { measure, states: 0, spacing: Spacing::Every(interval), end: f64::INFINITY }
    }
}

/// Infinity is no number in JSON.
mod end {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(end: &f64, to: S) -> Result<S::Ok, S::Error> {
        end.is_finite().then_some(*end).serialize(to)
    }

    pub(super) fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::INFINITY))
    }
}
