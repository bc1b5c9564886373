//! The curves of the training runs, each as predicted by what was fitted to other runs: what a second stage is judged by.

use std::collections::BTreeMap;

use super::predicted_curve::Curve;
use crate::curve::interpolated;

/// For each training run its predicted curves, of which nothing that was fitted has seen the run.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutCurves {
    points: Vec<f64>,
    runs: BTreeMap<String, Vec<Curve>>,
}

impl LeftOutCurves {
    /// From the curves of the outputs of each run, which start at a value of the run where `starts` gives one for its output.
    pub(super) fn new(
        points: Vec<f64>,
        names: impl Iterator<Item = String>,
        starts: &[Vec<f64>],
        mut curves: Vec<Vec<Curve>>,
    ) -> LeftOutCurves {
        for (run, starts) in curves.iter_mut().zip(starts) {
            for (curve, start) in run.iter_mut().zip(starts) {
                curve.mean.iter_mut().for_each(|mean| *mean += start);
            }
        }
        LeftOutCurves { points, runs: names.zip(curves).collect() }
    }

    /// The outputs of a run at a value of the coordinate: the mean of each, and the standard deviation of a run about it; `None` if the run was
    /// not used, or there were too few to leave any out.
    pub fn at(&self, run: &str, coordinate: f64) -> Option<Vec<[f64; 2]>> {
        let at = |values: &[f64]| interpolated(coordinate, &self.points, values);
        let value =
            |curve: &Curve| [at(&curve.mean), (at(&curve.parameters) + at(&curve.noise)).max(0.0).sqrt()];
        Some(self.runs.get(run)?.iter().map(value).collect())
    }
}
