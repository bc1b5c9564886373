//! The uncertainty of a surrogate from its errors on training runs that were left out of the fit.
//!
//! The standard deviation at a value of the coordinate is the root mean square of the errors in one of ten parts of it, linear between their
//! middles. Intervals are this deviation times a factor, which is chosen on the same runs so that the share of states in the intervals is the
//! level (conformal calibration by whole runs).

use serde::{Deserialize, Serialize};

use super::curve_process::Calibration;
use crate::curve::{increases, interpolated};
use crate::onnx::{self, OnnxEstimate, OnnxGraph, Value};
use crate::surrogate::prediction::{Cause, Estimate};

/// Number of parts of the coordinate.
const PARTS: usize = 10;
/// Fewest runs for intervals.
const FEWEST_RUNS: usize = 3;

/// The errors of left-out runs, as deviations along the coordinate and their calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeftOutErrors {
    /// Number of runs.
    runs: usize,
    /// Middles of the parts of the coordinate.
    at: Vec<f64>,
    /// Root mean square error in each.
    deviations: Vec<f64>,
    calibration: Calibration,
}

impl LeftOutErrors {
    /// From the states of each run: their coordinates (zero without a coordinate) and errors.
    pub fn new(runs: &[Vec<(f64, f64)>]) -> LeftOutErrors {
        let mut all: Vec<(f64, f64)> = runs.iter().flatten().copied().collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut at, mut deviations) = (Vec::new(), Vec::new());
        for part in all.chunks(all.len().div_ceil(PARTS).max(1)) {
            let count = part.len() as f64;
            let middle = part.iter().map(|(x, _)| x).sum::<f64>() / count;
            let square = part.iter().map(|(_, e)| e * e).sum::<f64>() / count;
            if at.last().is_none_or(|last| middle > *last) {
                at.push(middle);
                deviations.push(square.sqrt());
            }
        }
        let mut found =
            LeftOutErrors { runs: runs.len(), at, deviations, calibration: Calibration::default() };
        let scaled = |(x, error): &(f64, f64)| match found.deviation(*x) {
            deviation if deviation > 0.0 => error / deviation,
            _ => 0.0,
        };
        let scaled: Vec<Vec<f64>> = runs.iter().map(|run| run.iter().map(scaled).collect()).collect();
        let longest = scaled.iter().map(Vec::len).max().unwrap_or(0);
        found.calibration = Calibration::new(&scaled, &vec![1.0; longest]);
        found
    }

    /// The standard deviation of a new run at a coordinate.
    pub fn deviation(&self, x: f64) -> f64 {
        interpolated(x, &self.at, &self.deviations)
    }

    /// The factor on the standard deviation with which intervals hold the share `level` of the states of new runs.
    pub fn factor(&self, level: f64) -> f64 {
        self.calibration.interval(level)
    }

    /// A mean with the interval that a factor gives; without one from fewer than three runs.
    pub fn around(&self, mean: f64, x: f64, factor: f64) -> Estimate {
        let estimate = Estimate::new(mean);
        if self.runs < FEWEST_RUNS {
            return estimate;
        }
        estimate.by(vec![(Cause::Runs, self.deviation(x))], factor)
    }

    /// The result of [`LeftOutErrors::around`] in a graph, for a column of means and one of coordinates.
    pub fn onnx(&self, graph: &mut OnnxGraph, mean: Value, coordinate: &Value, factor: f64) -> OnnxEstimate {
        let deviation = (self.runs >= FEWEST_RUNS)
            .then(|| onnx::interpolated(graph, coordinate, &self.at, &self.deviations));
        OnnxEstimate { mean, spread: onnx::spread(graph, deviation, factor) }
    }

    /// True if the numbers are those of errors.
    pub fn is_sound(&self) -> bool {
        !self.at.is_empty()
            && increases(&self.at)
            && self.at.len() == self.deviations.len()
            && self.at.iter().all(|x| x.is_finite())
            && self.deviations.iter().all(|s| *s >= 0.0 && s.is_finite())
            && self.calibration.is_sound()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that grow along the coordinate, uniform between runs.
    #[test]
    fn intervals_hold_their_level_and_follow_the_errors() {
        let run = |k: u32| -> Vec<(f64, f64)> {
            let error = f64::from(k) / 50.0 - 1.0;
            (0..40).map(|i| f64::from(i) / 39.0).map(|x| (x, error * (0.1 + x))).collect()
        };
        let errors = LeftOutErrors::new(&(0..=100).map(run).collect::<Vec<_>>());
        assert!(errors.is_sound());
        let root = (1.0f64 / 3.0).sqrt();
        assert!((errors.deviation(0.5) / (0.6 * root) - 1.0).abs() < 0.05, "{}", errors.deviation(0.5));
        let interval = errors.around(2.0, 0.5, errors.factor(0.9)).interval.unwrap();
        assert!((0.5 * (interval.upper - interval.lower) - 0.9 * 0.6).abs() < 0.04, "{interval:?}");
        // Two runs say nothing of their scatter.
        let two = LeftOutErrors::new(&[run(1), run(2)]);
        assert!(two.is_sound() && two.around(1.0, 0.5, 1.0).interval.is_none());
        // Without a coordinate there is one part.
        let flat = LeftOutErrors::new(&vec![vec![(0.0, 1.0), (0.0, -1.0)]; 5]);
        assert!(flat.is_sound() && flat.deviation(7.0) == 1.0);
    }
}
