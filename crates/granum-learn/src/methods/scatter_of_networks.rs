//! What several networks, each of which was not trained on a part of the runs, tell about the error of their mean.
//!
//! ```text
//! variance between the networks                                    parameters
//! mean of e^2 less the first, at least 0                           runs, e the errors of each run in the network
//!                                                                  that was not trained on it
//! ```
//!
//! The half width of intervals is given by the quantile of Student's t distribution with the number of runs minus one as degrees of freedom.

use serde::{Deserialize, Serialize};

use crate::surrogate::prediction::{Cause, Estimate, Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::Columns;

/// How much runs deviate that a network was not trained on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RunVariances {
    /// For each output the variance beyond that between the networks.
    outputs: Vec<f64>,
    degrees_of_freedom: f64,
}

impl RunVariances {
    /// The variances of the errors that networks make for runs that they were not trained on: run `r` by network `r % networks`. `means` has the
    /// outputs of each network in row-major order, as `targets`.
    pub fn new(means: &[Vec<f64>], targets: &[f64], outputs: usize, lengths: &[usize]) -> RunVariances {
        let mut excess = vec![0.0; outputs];
        let mut row = 0;
        for (run, length) in lengths.iter().enumerate() {
            let own = &means[run % means.len()];
            for place in row * outputs..(row + length) * outputs {
                let error = own[place] - targets[place];
                excess[place % outputs] += error * error - mean_and_variance(means, place).1;
            }
            row += length;
        }
        let variances = excess.iter().map(|sum| (sum / row as f64).max(0.0)).collect();
        RunVariances { outputs: variances, degrees_of_freedom: lengths.len() as f64 - 1.0 }
    }

    /// True if they can be those of so many outputs.
    pub fn is_whole(&self, outputs: usize) -> bool {
        self.outputs.len() == outputs
            && self.outputs.iter().all(|variance| *variance >= 0.0 && variance.is_finite())
            && self.degrees_of_freedom >= 1.0
    }

    /// For each output the variance beyond that between the networks.
    pub fn variances(&self) -> &[f64] {
        &self.outputs
    }

    /// Student's quantile for intervals of a level.
    pub fn quantile(&self, level: f64) -> f64 {
        granum_nets::two_sided_quantile(level, self.degrees_of_freedom)
    }
}

/// Mean of the networks' values at a place, and the variance between them.
fn mean_and_variance(predictions: &[Vec<f64>], place: usize) -> (f64, f64) {
    let count = predictions.len() as f64;
    let mean = predictions.iter().map(|values| values[place]).sum::<f64>() / count;
    let squares: f64 = predictions.iter().map(|values| (values[place] - mean) * (values[place] - mean)).sum();
    (mean, squares / (count - 1.0).max(1.0))
}

/// The predictions for rows from the outputs of each network; without variances of runs there are no intervals. `ranges` are those of the inputs.
pub(super) fn predictions(
    networks: &[Vec<f64>],
    run_variances: Option<&RunVariances>,
    (columns, ranges): (&Columns, &[[f64; 2]]),
    inputs: &RunInputs,
    level: f64,
) -> Vec<Prediction> {
    let outputs = columns.outputs.len();
    let known = run_variances.map(|known| (known, known.quantile(level)));
    let predict = |(row, values): (usize, &[f64])| {
        let estimates = (0..outputs).map(|output| estimate(networks, known, row, output, outputs)).collect();
        Prediction::new(estimates).with_outside(outside_of(columns, ranges, values))
    };
    inputs.rows().enumerate().map(predict).collect()
}

/// The estimate of an output of a row; `known` are the variances and their quantile.
fn estimate(
    predictions: &[Vec<f64>],
    known: Option<(&RunVariances, f64)>,
    row: usize,
    output: usize,
    outputs: usize,
) -> Estimate {
    let (mean, between) = mean_and_variance(predictions, row * outputs + output);
    let Some((known, quantile)) = known else { return Estimate::new(mean) };
    let causes = vec![(Cause::Parameters, between.sqrt()), (Cause::Runs, known.outputs[output].sqrt())];
    Estimate::new(mean).by(causes, quantile)
}
