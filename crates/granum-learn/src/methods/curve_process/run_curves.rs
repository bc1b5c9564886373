//! The curves of runs on common points of the coordinate.

use crate::curve::interpolated;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};

/// Number of intervals between the points.
const INTERVALS: usize = 64;
/// The points are denser at the start, where curves change most: the distance from it grows as this power of their number.
const POWER: f64 = 1.6;

/// Points of the coordinate that all runs reach.
pub(in crate::methods) fn common_points(runs: &[RunCurve]) -> Result<Vec<f64>> {
    let start = runs.iter().map(|run| run.xs[0]).fold(f64::NEG_INFINITY, f64::max);
    let end = runs.iter().map(|run| run.xs[run.xs.len() - 1]).fold(f64::INFINITY, f64::min);
    if end <= start {
        return Err(LearnError::Dataset(format!(
            "there is no range of the coordinate that all runs have: one begins at {start}, one ends at {end}"
        )));
    }
    let share = |k: usize| granum_simd::power(k as f64 / INTERVALS as f64, POWER);
    let mut points: Vec<f64> = (0..=INTERVALS).map(|k| start + (end - start) * share(k)).collect();
    (points[0], points[INTERVALS]) = (start, end);
    Ok(points)
}

/// The part of the coordinate that each point stands for; the sum is 1.
pub(in crate::methods) fn shares(points: &[f64]) -> Vec<f64> {
    let last = points.len() - 1;
    let length = points[last] - points[0];
    let half = |a: usize, b: usize| 0.5 * (points[b] - points[a]) / length;
    (0..=last).map(|k| half(k.saturating_sub(1), (k + 1).min(last))).collect()
}

/// The states of a run along the coordinate.
pub(in crate::methods) struct RunCurve {
    /// The coordinate, increasing.
    pub xs: Vec<f64>,
    /// The values of each output.
    pub outputs: Vec<Vec<f64>>,
    /// The inputs beside the coordinate.
    pub inputs: Vec<f64>,
}

impl RunCurve {
    /// From a run: the last of its states in which the coordinate increases, since a stage before the test, such as a consolidation, may
    /// have states of its own.
    ///
    /// # Errors
    /// If that are fewer than half of the states, since the coordinate then turns, or an input is not constant.
    pub fn new(run: &RunStates, coordinate: &str, inputs: &[String], outputs: &[String]) -> Result<RunCurve> {
        let bad = |reason: String| LearnError::Record { run: run.name().into(), reason };
        let xs = run.column(coordinate)?;
        let finite = |name: &str, values: &[f64]| match values.iter().position(|value| !value.is_finite()) {
            Some(row) => Err(bad(format!("row {row}: {name} is {}, not a finite number", values[row]))),
            None => Ok(()),
        };
        finite(coordinate, &xs)?;
        let from = (1..xs.len()).rev().find(|&k| xs[k] <= xs[k - 1]).unwrap_or(0);
        let count = xs.len() - from;
        if count < 3 || 2 * count < xs.len() {
            return Err(bad(format!(
                "{coordinate} does not increase from state to state (only in the last {count} of {}), so that there is no curve over it",
                xs.len()
            )));
        }
        let column = |name: &String| {
            let values = run.column(name)?;
            finite(name, &values)?;
            Ok(values[from..].to_vec())
        };
        let constant = |name: &String| {
            let values = column(name)?;
            match values.iter().find(|value| **value != values[0]) {
                Some(other) => Err(bad(format!(
                    "{name} is not constant ({} and {other}); a curve depends on the coordinate and on what is constant in a run",
                    values[0]
                ))),
                None => Ok(values[0]),
            }
        };
        Ok(RunCurve {
            inputs: inputs.iter().map(constant).collect::<Result<_>>()?,
            outputs: outputs.iter().map(column).collect::<Result<_>>()?,
            xs: xs[from..].to_vec(),
        })
    }

    /// All runs of a data set.
    pub fn all(
        dataset: &Dataset,
        coordinate: &str,
        inputs: &[String],
        outputs: &[String],
    ) -> Result<Vec<RunCurve>> {
        dataset.runs().iter().map(|run| RunCurve::new(run, coordinate, inputs, outputs)).collect()
    }

    /// An output at the points, less the value of an input if `start` names one.
    pub fn at(&self, points: &[f64], output: usize, start: Option<usize>) -> Vec<f64> {
        let values = &self.outputs[output];
        let first = start.map_or(0.0, |input| self.inputs[input]);
        points.iter().map(|x| interpolated(*x, &self.xs, values) - first).collect()
    }
}
