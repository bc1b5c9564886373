//! Ridge regression beside networks, and its share in their predictions.
//!
//! What a linear model of the inputs knows, a network of few runs learns only in part: a network that is given a distribution point by
//! point hardly uses it, and one regularisation for all weights lets it use inputs less, or more, than runs support. The prediction is therefore
//! a mean of both,
//!
//! ```text
//! prediction = (1 - w) network + w ridge
//! ```
//!
//! Each run is left out in turn. With the errors `a` of the network, to first order, and `b` of ridge regression on runs that they have
//! not seen, `d = b - a`, and three independent errors for each of the n runs, since the deviation of a run persists over many states, the
//! evidence for `w` is that of a regression of `-a` on `d`,
//!
//! ```text
//! w_data = -<a d> / <d^2>,   precision p = 3 n <d^2> / <(a + w_data d)^2>      w_data between 0 and 1 in the second
//! w_0 = n / (n + 2),   w = (4 w_0 + p w_data) / (4 + p),  between 0 and 1
//! ```
//!
//! where the prior distribution of `w` is normal about `w_0` with a standard deviation of one half. Two runs determine the slopes of
//! ridge regression poorly and many runs well, which is what `w_0` says. Where both are alike, a mean of the two is nearly the best that there is, whatever few
//! runs say; where the truth is not linear, `p` is large, and the network stands alone. A single run cannot be left out: there the
//! network stands alone, too.

use serde::{Deserialize, Serialize};

use crate::curve::range;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::methods::FittedRidge;
use crate::onnx::{OnnxGraph, Value};
use crate::surrogate::{Columns, Content, FitSpec, RidgeRegression, RunInputs, Surrogate};

/// Number of runs with which ridge regression is expected to deserve half of the prediction before any run was left out.
const RUNS_FOR_HALF: f64 = 2.0;
/// Number of independent errors of a run in one quantity, whose deviation from other runs persists over many states.
const ERRORS_OF_RUN: f64 = 3.0;
/// Inverse of the variance of the share before any run was left out.
const PRIOR_PRECISION: f64 = 4.0;

/// Ridge regression with its share in the predictions of networks.
#[derive(Clone, Debug)]
pub(crate) struct RidgeShare {
    ridge: FittedRidge,
    /// The share in each output.
    shares: Vec<f64>,
    /// The smallest and the largest value of each output that it may predict: like a network, it does not go far beyond what was
    /// trained, wherever its inputs are.
    limits: Vec<[f64; 2]>,
}

/// A [`RidgeShare`] in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StoredRidgeShare {
    shares: Vec<f64>,
    limits: Vec<[f64; 2]>,
    ridge: serde_json::Value,
}

impl RidgeShare {
    /// Ridge regression that is fitted to a data set, with the given share in each output; `None` without any share, or if the equations
    /// cannot be solved, in which case the networks stand alone.
    pub fn fit(dataset: &Dataset, spec: &FitSpec, shares: Vec<f64>) -> Option<RidgeShare> {
        if shares.iter().all(|share| *share == 0.0) {
            return None;
        }
        let ridge = RidgeRegression::default().fit_means(dataset, spec).ok()?;
        let limits = ridge.columns().output_names();
        let limits = limits.iter().map(|name| dataset.column(name).ok().map(|values| widened(range(values))));
        Some(RidgeShare { limits: limits.collect::<Option<_>>()?, ridge, shares })
    }

    /// What ridge regression predicts for states, given as rows of its inputs: a row of outputs for each.
    ///
    /// # Errors
    /// If the rows are not rows of its inputs.
    pub fn means(&self, rows: Vec<f64>) -> Result<Vec<Vec<f64>>> {
        let columns = self.ridge.columns().inputs.len();
        let mut means = self.ridge.evaluate_means(&RunInputs::separate(rows, columns)?)?;
        for row in &mut means {
            row.iter_mut().zip(&self.limits).for_each(|(mean, [low, high])| *mean = mean.clamp(*low, *high));
        }
        Ok(means)
    }

    /// The prediction of an output from those of the network and of ridge regression.
    pub fn mixed(&self, output: usize, network: f64, ridge: f64) -> f64 {
        network + self.correction(output, network, ridge)
    }

    /// What is added to the prediction of the network.
    pub fn correction(&self, output: usize, network: f64, ridge: f64) -> f64 {
        self.shares[output] * (ridge - network)
    }

    /// What ridge regression predicts in the graph of an ONNX file, a column for each output.
    pub fn onnx(&self, graph: &mut OnnxGraph, inputs: &Value) -> Value {
        let means = self.ridge.onnx_means(graph, inputs);
        let [lows, highs] =
            [0, 1].map(|end| self.limits.iter().map(|limits| limits[end]).collect::<Vec<_>>());
        let (lows, highs) = (graph.row(&lows), graph.row(&highs));
        let means = graph.apply("Max", &[&means, &lows]);
        graph.apply("Min", &[&means, &highs])
    }

    /// [`RidgeShare::mixed`] in such a graph, for a column of values of the network; `ridge` is that of [`RidgeShare::onnx`].
    pub fn onnx_mixed(&self, graph: &mut OnnxGraph, output: usize, network: &Value, ridge: &Value) -> Value {
        let share = graph.number(self.shares[output]);
        let ridge = graph.columns(ridge, &[output]);
        let difference = graph.apply("Sub", &[&ridge, network]);
        let correction = graph.apply("Mul", &[&share, &difference]);
        graph.apply("Add", &[network, &correction])
    }

    /// The share in each output.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// It as a part of a file.
    ///
    /// # Errors
    /// If a number cannot be represented in JSON.
    pub fn stored(&self) -> Result<StoredRidgeShare> {
        let (shares, limits) = (self.shares.clone(), self.limits.clone());
        Ok(StoredRidgeShare { shares, limits, ridge: self.ridge.content()?.read()? })
    }
}

impl StoredRidgeShare {
    /// Recreates it for columns.
    ///
    /// # Errors
    /// If it does not belong to these columns.
    pub fn restored(self, columns: &Columns) -> Result<RidgeShare> {
        let ridge = RidgeRegression::default().loaded(columns.clone(), &Content::new(&self.ridge)?)?;
        let possible = self.shares.iter().all(|share| (0.0..=1.0).contains(share));
        if !possible || self.shares.len() != columns.outputs.len() {
            let (needed, count) = (columns.outputs.len(), self.shares.len());
            let reason =
                format!("the shares of ridge regression must be {needed} numbers from 0 to 1, not {count}");
            return Err(LearnError::Content(reason));
        }
        let ordered = self.limits.iter().all(|[low, high]| low <= high);
        if !ordered || self.limits.len() != columns.outputs.len() {
            let needed = columns.outputs.len();
            let reason = format!(
                "the limits of ridge regression must be {needed} pairs of a smaller and a larger number"
            );
            return Err(LearnError::Content(reason));
        }
        Ok(RidgeShare { ridge, shares: self.shares, limits: self.limits })
    }
}

/// The values that a network can have whose targets are scaled to [0.1, 0.9] of its output.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    let beyond = 0.125 * (high - low);
    [low - beyond, high + beyond]
}

/// The share of ridge regression that the errors of both on left-out runs support, pairs of (network, ridge regression). An output of one value varies in
/// one independent way, a histogram in several. Pairs that are not finite do not count.
pub(crate) fn supported_share(errors: &[(f64, f64)], runs: usize, ways: f64) -> f64 {
    let (mut network, mut product, mut square) = (0.0, 0.0, 0.0);
    for (a, b) in errors.iter().filter(|(a, b)| a.is_finite() && b.is_finite()) {
        let difference = b - a;
        network += a * a;
        product += a * difference;
        square += difference * difference;
    }
    let expected = runs as f64 / (runs as f64 + RUNS_FOR_HALF);
    let supported = -product / square;
    if !supported.is_finite() {
        return expected;
    }
    let nearest = supported.clamp(0.0, 1.0);
    let left = network + nearest * (2.0 * product + nearest * square);
    // Where nothing is left but rounding, the precision is the largest that has a meaning.
    let left = left.max(f64::EPSILON * (network + square)).max(f64::MIN_POSITIVE);
    let precision = runs as f64 * ERRORS_OF_RUN * ways * square / left;
    let share = (PRIOR_PRECISION * expected + precision * supported) / (PRIOR_PRECISION + precision);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_the_formula() {
        // <a d> = -1, <d^2> = 2 and <(a + d/2)^2> = 0.5, so that n runs support one half with p = 3 n (2 / 0.5).
        let alike = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        assert_eq!(supported_share(&alike, 2, 1.0), 0.5);
        assert!((supported_share(&alike, 6, 1.0) - (3.0 + 36.0) / (4.0 + 72.0)).abs() < 1e-15);
        // The network has the errors 1 and -1, ridge regression those and 3 more: nothing supports it, but two errors say little.
        let worse = [(1.0, 4.0), (-1.0, 2.0)];
        let precision = 2.0 * 3.0 * 9.0;
        assert!((supported_share(&worse, 2, 1.0) - 2.0 / (4.0 + precision)).abs() < 1e-15);
        assert!((supported_share(&worse, 2, 3.0) - 2.0 / (4.0 + 3.0 * precision)).abs() < 1e-15);
        let better = [(4.0, 1.0), (2.0, -1.0)];
        assert!((supported_share(&better, 2, 1.0) - (2.0 + precision) / (4.0 + precision)).abs() < 1e-15);
        // A share of 1.2 would leave the errors 1 and -1, and the largest that is possible, 1, the errors 1.2 and -0.8 of ridge
        // regression, by which its precision is judged.
        let beyond = [(2.2, 1.2), (0.2, -0.8)];
        let precision = 2.0 * 3.0 * 1.0 / 1.04;
        let share = (2.0 + 1.2 * precision) / (4.0 + precision);
        assert!((supported_share(&beyond, 2, 1.0) - share).abs() < 1e-14);
        // Errors of ridge regression that are twice those of the network speak for less than no share.
        assert_eq!(supported_share(&[(1.0, 2.0), (-1.0, -2.0)], 6, 1.0), 0.0);
    }

    #[test]
    fn without_a_difference_runs_decide_and_without_errors_one_stands_alone() {
        for errors in [&[][..], &[(f64::NAN, 1.0)], &[(0.3, 0.3), (0.1, 0.1)]] {
            assert_eq!([2, 6].map(|runs| supported_share(errors, runs, 1.0)), [0.5, 0.75]);
        }
        assert!(supported_share(&[(0.0, 0.3), (0.0, -0.1)], 3, 1.0) < 1e-12);
        assert!(supported_share(&[(0.3, 0.0), (-0.1, 0.0)], 3, 1.0) > 1.0 - 1e-12);
    }
}
