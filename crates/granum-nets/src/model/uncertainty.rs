//! The uncertainty of a trained network by the Laplace approximation that belongs to Bayesian regularisation (MacKay 1992).
//!
//! With the precisions `alpha` of the weights and `beta` of the noise, the weights are normally distributed around the
//! trained ones with covariance `(beta J^T J + alpha I)^-1`, and an observation at an input where the network's gradient with
//! respect to its weights is `g` has the variance
//!
//! ```text
//! 1 / beta + g^T (beta J^T J + alpha I)^-1 g  =  1 / beta + (g . g - k^T (K + a I)^-1 k) / alpha
//! ```
//!
//! with `a = alpha / beta`, `K = J J^T` and `k = J g`, which are computed along the few directions that the rows determine (see `curvature/determined.rs`).

use granum_simd::Isa;
use serde::{Deserialize, Serialize};

use crate::feed_forward::backprop::Workspace;
use crate::feed_forward::curvature::{Curvature, Determined};
use crate::feed_forward::network::Network;
use crate::table::data::Data;
use crate::trainer::report::Evidence;

/// Limit on the memory for the curvature, bytes.
const MEMORY: usize = 2 << 30;
/// Number of rows whose variances are computed together, so that what is computed of them stays in the second-level cache.
const CHUNK: usize = 96;

/// The training rows of a network in scaled units, without their targets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrainingRows {
    /// The inputs in row-major order.
    pub inputs: Vec<f64>,
    /// Weight of each row.
    pub weights: Option<Vec<f64>>,
    /// Number of rows of each observation.
    #[serde(default = "one")]
    pub points: usize,
}

fn one() -> usize {
    1
}

impl TrainingRows {
    /// Refuses rows that do not match the network or would need too much memory.
    pub(crate) fn check(&self, network: &Network) -> Result<(), String> {
        let data = self.data(network).map_err(|e| format!("training rows: {e}"))?;
        let bytes = needed(network, &data);
        if bytes > MEMORY {
            return Err(format!(
                "the uncertainty over {} training rows would need {bytes} bytes",
                data.rows()
            ));
        }
        Ok(())
    }

    fn data(&self, network: &Network) -> Result<Data, crate::table::data_error::DataError> {
        let rows = self.inputs.len() / network.inputs();
        let data = Data::new(self.inputs.clone(), network.inputs(), vec![0.0; rows])?;
        match &self.weights {
            Some(weights) if self.points > 1 => {
                data.with_points(self.points)?.with_observations(weights.iter().sum())
            }
            Some(weights) => data.with_weights(weights.clone())?.with_observations(weights.iter().sum()),
            None => data.with_points(self.points),
        }
    }
}

fn needed(network: &Network, data: &Data) -> usize {
    let rows = data.rows();
    let curvature = Curvature::bytes(rows, rows / data.points(), network.weights().len());
    curvature.saturating_add(Workspace::bytes(network, rows))
}

/// The uncertainty of a trained network in numbers, for programs that evaluate it without this crate. In scaled units, an observation at which the output of the network has the
/// gradient `g` with respect to its weights has the variance
///
/// ```text
/// 1 / beta + (max(g . g - sum_d (v_d . g)^2, 0) + sum_d open_d (v_d . g)^2) / alpha
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Uncertainty {
    /// Precision of the weights.
    pub alpha: f64,
    /// Precision of the noise.
    pub beta: f64,
    /// Number of weights.
    pub weights: usize,
    /// The orthonormal directions that the training rows determine, `weights x directions` in row-major order.
    pub directions: Vec<f64>,
    /// What is left open of each.
    pub open: Vec<f64>,
}

/// What the training rows of a network determine of its weights.
#[derive(Clone)]
pub(crate) struct Laplace {
    isa: Isa,
    determined: Determined,
    alpha: f64,
    beta: f64,
}

impl std::fmt::Debug for Laplace {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Laplace")
            .field("alpha", &self.alpha)
            .field("beta", &self.beta)
            .finish_non_exhaustive()
    }
}

impl Laplace {
    /// Forms the curvature at the weights of the network; `None` if the rows do not match the network, if there are
    /// too many of them, or if the curvature is not finite.
    pub(crate) fn new(
        isa: Isa,
        network: &Network,
        rows: &TrainingRows,
        evidence: Evidence,
    ) -> Option<Laplace> {
        let data = rows.data(network).ok()?;
        if needed(network, &data) > MEMORY {
            return None;
        }
        let mut training = Workspace::new(isa, network, &data);
        training.squared_error(network.weights());
        training.sensitivities(network.weights());
        let shift = evidence.alpha / evidence.beta;
        let (determined, shift) = Determined::new(&training, network.weights().len(), shift)?;
        Some(Laplace { isa, determined, alpha: shift * evidence.beta, beta: evidence.beta })
    }

    /// The same in numbers.
    pub(crate) fn numbers(&self, weights: usize) -> Uncertainty {
        let (directions, open) = self.determined.directions(weights);
        Uncertainty { alpha: self.alpha, beta: self.beta, weights, directions, open }
    }

    /// The noise part of the variance of an observation.
    pub(crate) fn noise(&self) -> f64 {
        1.0 / self.beta
    }

    /// The outputs of the network for rows in scaled units, and the variances of observations with so many points each. For a scaled input that is
    /// not finite the variance is infinite, and the outputs are not a number.
    pub(crate) fn outputs_and_variances(
        &self,
        network: &Network,
        mut inputs: Vec<f64>,
        points: usize,
    ) -> (Vec<f64>, Vec<f64>) {
        let width = network.inputs() * points;
        let beyond: Vec<bool> =
            inputs.chunks(width).map(|point| point.iter().any(|x| !x.is_finite())).collect();
        inputs.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = 0.0);
        let (mut outputs, mut variances) = self.of_numbers(network, &inputs, points);
        for (k, _) in beyond.iter().enumerate().filter(|(_, beyond)| **beyond) {
            variances[k] = f64::INFINITY;
            outputs[k * points..(k + 1) * points].fill(f64::NAN);
        }
        (outputs, variances)
    }

    fn of_numbers(&self, network: &Network, inputs: &[f64], points: usize) -> (Vec<f64>, Vec<f64>) {
        let count = inputs.len() / network.inputs();
        let (mut outputs, mut variances) = (Vec::with_capacity(count), Vec::with_capacity(count / points));
        let mut workspace: Option<Workspace> = None;
        for chunk in inputs.chunks(CHUNK.div_ceil(points) * network.inputs() * points) {
            let rows = chunk.len() / network.inputs();
            let asked = match &mut workspace {
                Some(asked) if asked.rows == rows => {
                    asked.set_inputs(chunk);
                    asked
                }
                other => {
                    let data = Data::new(chunk.to_vec(), network.inputs(), vec![0.0; rows])
                        .and_then(|data| data.with_points(points));
                    let Ok(data) = data else { continue };
                    other.insert(Workspace::new(self.isa, network, &data))
                }
            };
            asked.squared_error(network.weights());
            asked.sensitivities(network.weights());
            outputs.extend(asked.first_outputs());
            let unknown = self.determined.uncertainties(asked);
            variances.extend(unknown.iter().map(|u| 1.0 / self.beta + u / self.alpha));
        }
        (outputs, variances)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network_and_rows() -> (Network, TrainingRows) {
        let network = Network::new(&[2, 6, 5, 1], 9).unwrap();
        let inputs = (0..60).map(|k| (k as f64 * 1.3).sin()).collect();
        let weights = Some((0..30).map(|r| 0.5 + (r % 4) as f64).collect());
        (network, TrainingRows { inputs, weights, points: 1 })
    }

    /// `1 / beta + g^T (beta J^T J + alpha I)^-1 g` with explicit matrices, by Gaussian elimination.
    fn explicit(network: &Network, rows: &TrainingRows, evidence: Evidence, asked: [f64; 2]) -> f64 {
        let count = network.weights().len();
        let gradient = |input: &[f64]| -> Vec<f64> {
            let mut changed = network.clone();
            (0..count)
                .map(|k| {
                    let (h, before) = (1e-5, network.weights()[k]);
                    changed.weights_mut()[k] = before + h;
                    let up = changed.forward(input).unwrap()[0];
                    changed.weights_mut()[k] = before - h;
                    let down = changed.forward(input).unwrap()[0];
                    changed.weights_mut()[k] = before;
                    (up - down) / (2.0 * h)
                })
                .collect()
        };
        let data = rows.data(network).unwrap();
        let mut a = vec![vec![0.0; count + 1]; count];
        for (r, input) in data.inputs().chunks(2).enumerate() {
            let g = gradient(input);
            for p in 0..count {
                for s in 0..count {
                    a[p][s] += evidence.beta * data.weights().unwrap()[r] * g[p] * g[s];
                }
            }
        }
        let g = gradient(&asked);
        for p in 0..count {
            a[p][p] += evidence.alpha;
            a[p][count] = g[p];
        }
        for p in 0..count {
            for s in p + 1..count {
                let factor = a[s][p] / a[p][p];
                for k in p..=count {
                    a[s][k] -= factor * a[p][k];
                }
            }
        }
        for p in (0..count).rev() {
            let sum: f64 = (p + 1..count).map(|k| a[p][k] * a[k][count]).sum();
            a[p][count] = (a[p][count] - sum) / a[p][p];
        }
        1.0 / evidence.beta + (0..count).map(|p| g[p] * a[p][count]).sum::<f64>()
    }

    #[test]
    fn variances_are_the_explicit_formula() {
        let (network, rows) = network_and_rows();
        let evidence = Evidence { alpha: 0.3, beta: 50.0, gamma: 10.0 };
        let laplace = Laplace::new(Isa::detect(), &network, &rows, evidence).unwrap();
        let asked = vec![0.2, -0.4, 1.5, 0.9, -2.0, 3.0];
        let variances = laplace.outputs_and_variances(&network, asked.clone(), 1).1;
        for (r, input) in asked.chunks(2).enumerate() {
            let expected = explicit(&network, &rows, evidence, [input[0], input[1]]);
            assert!((variances[r] / expected - 1.0).abs() < 1e-6, "{} {expected}", variances[r]);
        }
    }

    #[test]
    fn nothing_is_known_beyond_all_numbers() {
        let (network, rows) = network_and_rows();
        let evidence = Evidence { alpha: 0.3, beta: 50.0, gamma: 10.0 };
        let laplace = Laplace::new(Isa::detect(), &network, &rows, evidence).unwrap();
        let alone = laplace.outputs_and_variances(&network, vec![0.2, -0.4], 1).1;
        let asked = vec![f64::INFINITY, 0.0, 0.2, -0.4, 1.0, f64::NEG_INFINITY];
        let found = laplace.outputs_and_variances(&network, asked, 1).1;
        assert_eq!(found, [f64::INFINITY, alone[0], f64::INFINITY]);
    }

    /// The variance by its numbers, with the gradient by central differences.
    #[test]
    fn the_numbers_give_the_same_variances() {
        let (network, rows) = network_and_rows();
        let evidence = Evidence { alpha: 0.4, beta: 7.0, gamma: 10.0 };
        let laplace = Laplace::new(Isa::detect(), &network, &rows, evidence).unwrap();
        let count = network.weights().len();
        let known = laplace.numbers(count);
        let directions = known.open.len();
        assert!(directions > 0 && known.directions.len() == directions * count);
        let asked = [0.3, -1.7];
        let gradient: Vec<f64> = (0..count)
            .map(|k| {
                let moved = |h: f64| {
                    let mut changed = network.clone();
                    changed.weights_mut()[k] += h;
                    changed.forward(&asked).unwrap()[0]
                };
                (moved(1e-5) - moved(-1e-5)) / 2e-5
            })
            .collect();
        let mut rest: f64 = gradient.iter().map(|g| g * g).sum();
        let mut left = 0.0;
        for d in 0..directions {
            let along: f64 = (0..count).map(|k| gradient[k] * known.directions[k * directions + d]).sum();
            rest -= along * along;
            left += known.open[d] * along * along;
        }
        let variance = 1.0 / known.beta + (rest.max(0.0) + left) / known.alpha;
        let expected = laplace.outputs_and_variances(&network, asked.to_vec(), 1).1[0];
        assert!((variance / expected - 1.0).abs() < 1e-6, "{variance} {expected}");
    }

    #[test]
    fn rows_that_do_not_fit_are_refused() {
        let (network, mut rows) = network_and_rows();
        assert!(rows.check(&network).is_ok());
        rows.inputs.pop();
        assert!(rows.check(&network).is_err());
        rows.inputs.push(f64::INFINITY);
        assert!(rows.check(&network).unwrap_err().contains("not a finite number"));
    }
}
