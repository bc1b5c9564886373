//! How long a curve remembers where it started.

use serde::{Deserialize, Serialize};

/// Length of a short memory as a part of the range of the coordinate: the coordination number of sand forgets within some two per cent of
/// strain, of 25 that a test has, how it was in the sample.
const SHORT: f64 = 1.0 / 12.0;

/// The part of the start of a run that its curve keeps: `exp(-(x - x_0) / length)` of the difference from the mean of the training runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StartMemory {
    /// The mean start of the training runs.
    pub centre: f64,
    /// The distance along the coordinate after which 1/e of the difference is left.
    pub length: f64,
}

impl StartMemory {
    /// A short memory, for runs that started at these values.
    pub fn short(starts: &[f64], points: &[f64]) -> StartMemory {
        let centre = starts.iter().sum::<f64>() / starts.len().max(1) as f64;
        StartMemory { centre, length: SHORT * (points[points.len() - 1] - points[0]) }
    }

    /// What is added to a curve that started at `start`, at a distance from there.
    pub fn value(&self, start: f64, distance: f64) -> f64 {
        start - (start - self.centre) * (1.0 - granum_simd::exp(-distance / self.length))
    }

    /// True if it can be one.
    pub fn is_sound(&self) -> bool {
        self.centre.is_finite() && self.length.is_finite() && self.length > 0.0
    }
}
