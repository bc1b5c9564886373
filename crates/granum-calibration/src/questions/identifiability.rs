//! What measured curves can tell of parameters, before anything is inferred.
//!
//! Near a point, curves depend on shares of priors as `J du`, and tell of them the Fisher information `F = J^T C^-1 J` with the covariance C
//! of their errors. A uniform prior of a share has the variance 1/12, so that the posterior has about the covariance
//! `(F + 12 I)^-1`: its deviations over those of the prior are the contractions. 1: the curves tell nothing; 0: all.
//! Directions are the eigenvectors of F: combinations of parameters that curves fix, and those that they leave free.

use granum_learn::regression::cholesky::Cholesky;
use granum_nets::eigenvectors;
use serde::{Deserialize, Serialize};

use crate::compared::curve::{ForwardModel, MeasuredCurve, PredictedCurve};
use crate::error::{CalibrationError, Result};
use crate::inference::likelihood::{FreeParameter, Posterior, groups};

/// Half of the difference of shares over which slopes are taken.
const STEP: f64 = 0.02;
/// Precision of a share with a uniform prior.
const PRIOR_PRECISION: f64 = 12.0;

/// A combination of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Direction {
    /// Its part in each parameter's share; the squares add up to one.
    pub parts: Vec<f64>,
    /// Deviation of the posterior over that of the prior along it.
    pub contraction: f64,
}

/// What curves tell of parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identifiability {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// For each parameter, deviation of its posterior over that of its prior while all others are free.
    pub contraction: Vec<f64>,
    /// The same while all others are known.
    pub alone: Vec<f64>,
    /// Correlations of the posterior between parameters, row-major.
    pub correlation: Vec<f64>,
    /// The directions, the one that is fixed best first.
    pub directions: Vec<Direction>,
}

impl Identifiability {
    /// Pairs of parameters that the curves do not separate: each would be fixed if the other were known (to a half of its prior or better), but
    /// with both free they compensate each other with a correlation of 0.9 or more.
    pub fn not_separated(&self) -> Vec<[usize; 2]> {
        let count = self.names.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j]));
        pairs
            .filter(|[i, j]| {
                self.correlation[i * count + j].abs() >= 0.9 && self.alone[*i] < 0.5 && self.alone[*j] < 0.5
            })
            .collect()
    }

    /// Parameters of which the curves tell next to nothing, even if all others were known: their deviation stays above nine tenths of the
    /// prior's.
    pub fn not_seen(&self) -> Vec<usize> {
        (0..self.names.len()).filter(|k| self.alone[*k] > 0.9).collect()
    }
}

/// What the curves whose places are in `chosen` would tell of the parameters, with the mean Fisher information at points of the cube of
/// shares.
///
/// # Errors
/// If there are no points, a curve has no sense, or the model has no prediction at or near a point.
pub fn identifiability(
    parameters: &[FreeParameter],
    curves: &[MeasuredCurve],
    chosen: &[usize],
    model: &dyn ForwardModel,
    points: &[Vec<f64>],
) -> Result<Identifiability> {
    let fisher = fisher_information(parameters, curves, chosen, model, points)?;
    from_fisher(parameters.iter().map(|free| free.name.clone()).collect(), &fisher)
}

/// The mean over points of the Fisher information of the shares of the parameters, row-major, by the curves whose places are in `chosen`.
///
/// # Errors
/// As [`identifiability`].
pub fn fisher_information(
    parameters: &[FreeParameter],
    curves: &[MeasuredCurve],
    chosen: &[usize],
    model: &dyn ForwardModel,
    points: &[Vec<f64>],
) -> Result<Vec<f64>> {
    let posterior = Posterior::new(parameters, curves, model, None)?;
    let count = parameters.len();
    let mut fisher = vec![0.0; count * count];
    if points.is_empty() {
        return Err(CalibrationError::Input("identifiability needs a point at which it is asked".into()));
    }
    for point in points {
        add_fisher(&mut fisher, &posterior, chosen, model, point)?;
    }
    fisher.iter_mut().for_each(|entry| *entry /= points.len() as f64);
    Ok(fisher)
}

/// For each parameter the deviation of its posterior over that of its prior while all others are free, with a Fisher information of shares.
///
/// # Errors
/// If it is not finite.
pub(crate) fn contractions(fisher: &[f64], count: usize) -> Result<Vec<f64>> {
    let covariance = posterior_covariance(fisher, count)?;
    Ok((0..count).map(|k| (PRIOR_PRECISION * covariance[k][k]).sqrt()).collect())
}

/// The covariance of the posterior of shares, `(F + 12 I)^-1`.
fn posterior_covariance(fisher: &[f64], count: usize) -> Result<Vec<Vec<f64>>> {
    let factor = Cholesky::new(count, &precision(fisher, count))
        .ok_or_else(|| CalibrationError::Input("the Fisher information is not finite".into()))?;
    let column = |k: usize| {
        let mut unit = vec![0.0; count];
        unit[k] = 1.0;
        factor.solve(&unit)
    };
    Ok((0..count).map(column).collect())
}

/// The precision of the posterior of shares.
pub(crate) fn precision(fisher: &[f64], count: usize) -> Vec<f64> {
    let mut precision = fisher.to_vec();
    (0..count).for_each(|k| precision[k * count + k] += PRIOR_PRECISION);
    precision
}

fn add_fisher(
    fisher: &mut [f64],
    posterior: &Posterior,
    chosen: &[usize],
    model: &dyn ForwardModel,
    point: &[f64],
) -> Result<()> {
    let predict = |shares: &[f64]| {
        let values = posterior.values(shares);
        model.predict(&values).ok_or_else(|| {
            CalibrationError::Input(format!("the model has no prediction at the parameters {values:?}"))
        })
    };
    let middle = predict(point)?;
    let mut beside = Vec::new();
    for k in 0..point.len() {
        let at = |x: f64| {
            let mut shares = point.to_vec();
            shares[k] = x;
            predict(&shares)
        };
        let [low, high] = [(point[k] - STEP).max(0.0), (point[k] + STEP).min(1.0)];
        beside.push((at(low)?, at(high)?, high - low));
    }
    for group in groups(&middle, chosen) {
        let covariance = posterior.covariance_of_group(&group, &middle, &[]);
        let length = group.iter().map(|curve| middle[*curve].mean.len()).sum();
        let factor = Cholesky::new(length, &covariance).ok_or_else(|| {
            CalibrationError::Input("the covariance of the errors of a curve is not positive definite".into())
        })?;
        let slope = |(low, high, apart): &(Vec<PredictedCurve>, Vec<PredictedCurve>, f64)| -> Vec<f64> {
            let of_curve = |curve: &usize| {
                let (low, high) = (&low[*curve].mean, &high[*curve].mean);
                high.iter().zip(low).map(|(b, a)| (b - a) / apart).collect::<Vec<f64>>()
            };
            group.iter().flat_map(of_curve).collect()
        };
        let scaled: Vec<Vec<f64>> = beside.iter().map(|ends| factor.solve_lower(&slope(ends))).collect();
        for i in 0..point.len() {
            for j in 0..point.len() {
                fisher[i * point.len() + j] +=
                    scaled[i].iter().zip(&scaled[j]).map(|(a, b)| a * b).sum::<f64>();
            }
        }
    }
    Ok(())
}

/// The summary of a Fisher information of shares.
fn from_fisher(names: Vec<String>, fisher: &[f64]) -> Result<Identifiability> {
    let count = names.len();
    let precision = precision(fisher, count);
    let covariance = posterior_covariance(fisher, count)?;
    let correlation = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
    let correlation =
        correlation.map(|(i, j)| covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt()).collect();
    let (values, vectors) = eigenvectors(fisher.to_vec(), count);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let direction = |k: usize| Direction {
        parts: (0..count).map(|i| vectors[i * count + k]).collect(),
        contraction: (PRIOR_PRECISION / (values[k].max(0.0) + PRIOR_PRECISION)).sqrt(),
    };
    Ok(Identifiability {
        contraction: (0..count).map(|k| (PRIOR_PRECISION * covariance[k][k]).sqrt()).collect(),
        alone: (0..count).map(|k| (PRIOR_PRECISION / precision[k * count + k]).sqrt()).collect(),
        correlation,
        directions: order.into_iter().map(direction).collect(),
        names,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::curve::PredictedCurve;
    use crate::inference::prior::Prior;

    fn uniform(name: &str) -> FreeParameter {
        FreeParameter { name: name.into(), prior: Prior::Uniform { from: 0.0, to: 1.0 } }
    }

    /// The first curve sees the sum of a and b, the second their difference; neither sees c.
    fn model(values: &[f64]) -> Option<Vec<PredictedCurve>> {
        let [a, b] = [values[0], values[1]];
        let constant = |value: f64| PredictedCurve { mean: vec![value; 2], ..PredictedCurve::default() };
        Some(vec![constant(a + b), constant(a - b)])
    }

    #[test]
    fn a_sum_does_not_separate_and_a_difference_beside_it_does() {
        let parameters = ["friction", "rolling_friction", "density"].map(uniform);
        let curves = [MeasuredCurve::of_ones("deviator_stress"), MeasuredCurve::of_ones("volumetric_strain")];
        let ask = |chosen: &[usize]| {
            identifiability(&parameters, &curves, chosen, &model, &[vec![0.5; 3], vec![0.0, 1.0, 0.3]])
                .unwrap()
        };
        let one = ask(&[0]);
        assert_eq!((one.not_separated(), one.not_seen()), (vec![[0, 1]], vec![2]));
        // Golden: F = 2 / 0.01^2 (1 1; 1 1), of which only the sum is fixed: the other direction keeps its prior, so that each of the
        // two has the deviation 1 / sqrt 2 of its prior.
        assert!((one.contraction[0] - 0.5f64.sqrt()).abs() < 1e-3, "{:?}", one.contraction);
        assert!((one.alone[0] - (12.0f64 / 20_012.0).sqrt()).abs() < 1e-9, "{:?}", one.alone);
        assert!((one.directions[0].parts[0] - one.directions[0].parts[1]).abs() < 1e-9);
        assert!((one.directions[0].contraction - (12.0f64 / 40_012.0).sqrt()).abs() < 1e-9);
        assert_eq!(one.contraction[2], 1.0);
        let both = ask(&[0, 1]);
        assert_eq!(both.not_separated(), Vec::<[usize; 2]>::new());
        assert!(both.contraction[..2].iter().all(|c| *c < 0.02), "{:?}", both.contraction);
    }

    #[test]
    fn where_there_is_no_prediction_is_said() {
        let nowhere = |_: &[f64]| None;
        let message =
            identifiability(&[uniform("a")], &[MeasuredCurve::of_ones("q")], &[0], &nowhere, &[vec![0.5]]);
        assert!(message.unwrap_err().to_string().contains("no prediction at the parameters [0.5]"));
    }
}
