//! Importance sampling in rounds, for a model of which every evaluation costs a simulation.
//!
//! A round proposes points, a simulation at each gives the logarithm of its likelihood, and all points of all rounds are weighted together,
//! so that no simulation is lost. The first round fills the prior evenly. Each later one draws from a smooth approximation of the
//! posterior so far: a normal kernel about every weighted point. Where few points carry all the weight, the approximation is that of a
//! likelihood with a smaller exponent, which grows to one from round to round. Rounds end when the posterior no longer moves.
//!
//! Points are shares of priors; kernels live in the normal quantiles of shares, which have no bounds.
//!
//! Sources: weighting of all rounds by the mixture of their proposals, Cornuet, Marin, Mira, Robert, Adaptive multiple importance
//! sampling, Scandinavian Journal of Statistics 39 (2012), 798 to 812; kernels that keep mean and covariance, West, Journal of the Royal
//! Statistical Society B 55 (1993), 409 to 422. GrainLearning (Cheng and others, Computer Methods in Applied Mechanics and Engineering 350
//! (2019), 268 to 294) samples in rounds in the same spirit, with an error of the measurement that is chosen such that enough points count.

use granum_learn::regression::cholesky::Cholesky;
use granum_nets::normal::{quantile, share_below};
use serde::{Deserialize, Serialize};

use crate::draws::random::{standard_normal, stream, unit};
use crate::error::{CalibrationError, Result};

/// Shares this near to 0 and 1 are not proposed: their normal quantiles would be infinite.
const NEAREST: f64 = 1e-9;

const NEEDS_LOGARITHMS: &str =
    "each point of a round needs the finite logarithm of its likelihood, or minus infinity";

/// How rounds are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SequentialOptions {
    /// Points of a round (64).
    pub points: usize,
    /// Points that must count for the approximation of the posterior, by their effective number (16).
    pub least_effective: f64,
    /// Effective number of points that the final posterior must have (32).
    pub final_effective: f64,
    /// Change of every mean between two rounds, over its deviation, below which the posterior does not move any more (0.15).
    pub most_change: f64,
    /// Seed.
    pub seed: u64,
}

impl Default for SequentialOptions {
    fn default() -> Self {
        SequentialOptions {
            points: 64,
            least_effective: 16.0,
            final_effective: 32.0,
            most_change: 0.15,
            seed: 1,
        }
    }
}

/// The approximation of the posterior from which a round was drawn: a kernel about each of its centres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Kernels {
    centres: Vec<Vec<f64>>,
    weights: Vec<f64>,
    /// Lower factor of the covariance of a kernel, row-major.
    factor: Vec<f64>,
    log_determinant: f64,
}

/// The rounds so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sequential {
    options: SequentialOptions,
    dimension: usize,
    /// Normal quantiles of the shares of all points that have been simulated.
    points: Vec<Vec<f64>>,
    log_likelihoods: Vec<f64>,
    /// For each round, the number of its points and what they were drawn from; the first is drawn from the prior.
    rounds: Vec<(usize, Option<Kernels>)>,
    proposed: Option<Kernels>,
    /// Mean and deviation of each share after each round.
    moments: Vec<Vec<[f64; 2]>>,
}

impl Sequential {
    /// No rounds yet, for so many free parameters.
    pub fn new(dimension: usize, options: SequentialOptions) -> Sequential {
        Sequential {
            options,
            dimension,
            points: Vec::new(),
            log_likelihoods: Vec::new(),
            rounds: Vec::new(),
            proposed: None,
            moments: Vec::new(),
        }
    }

    /// Number of complete rounds.
    pub fn rounds(&self) -> usize {
        self.rounds.len()
    }

    /// The shares of the priors at which the next round is to be simulated.
    ///
    /// # Errors
    /// If the likelihood is zero at all points so far.
    pub fn propose(&mut self) -> Result<Vec<Vec<f64>>> {
        let round = self.rounds.len() as u64;
        if round == 0 {
            let seed = self.options.seed as u32;
            let coordinate =
                |point: usize, k: usize| f64::from(sobol_burley::sample(point as u32, k as u32, seed));
            let points = (0..self.options.points).map(|point| {
                (0..self.dimension).map(|k| coordinate(point, k).clamp(NEAREST, 1.0 - NEAREST)).collect()
            });
            return Ok(points.collect());
        }
        let kernels = self.kernels()?;
        let mut random = stream(self.options.seed, round);
        let draw = |_| {
            let mut left = unit(&mut random);
            let centre = kernels.weights.iter().position(|weight| {
                left -= weight;
                left < 0.0
            });
            let centre = &kernels.centres[centre.unwrap_or(kernels.centres.len() - 1)];
            let normal: Vec<f64> = (0..self.dimension).map(|_| standard_normal(&mut random)).collect();
            let coordinate = |i: usize| {
                let row = &kernels.factor[i * self.dimension..i * self.dimension + i + 1];
                let z = centre[i] + row.iter().zip(&normal).map(|(l, z)| l * z).sum::<f64>();
                share_below(z).clamp(NEAREST, 1.0 - NEAREST)
            };
            (0..self.dimension).map(coordinate).collect()
        };
        let points = (0..self.options.points).map(draw).collect();
        self.proposed = Some(kernels);
        Ok(points)
    }

    /// Takes the results of a round: the logarithms of the likelihood at the points that were proposed, minus infinity where a simulation
    /// failed.
    ///
    /// # Errors
    /// If the numbers of points and results differ, or a result is not a number.
    pub fn take(&mut self, shares: &[Vec<f64>], log_likelihoods: &[f64]) -> Result<()> {
        let fits =
            shares.len() == log_likelihoods.len() && shares.iter().all(|point| point.len() == self.dimension);
        if !fits || log_likelihoods.iter().any(|value| !is_logarithm(*value)) {
            return Err(CalibrationError::Input(NEEDS_LOGARITHMS.into()));
        }
        self.points.extend(shares.iter().map(|point| point.iter().map(|share| quantile(*share)).collect()));
        self.log_likelihoods.extend(log_likelihoods);
        self.rounds.push((shares.len(), self.proposed.take()));
        let moments = self.moments_now();
        self.moments.push(moments);
        Ok(())
    }

    /// Takes the place of the logarithms of the likelihood of all points so far, before those of a further round are taken: for a likelihood whose
    /// errors are estimated from all rounds together.
    ///
    /// # Errors
    /// If the numbers of points and results differ, or a result is not a number.
    pub fn judge_again(&mut self, log_likelihoods: &[f64]) -> Result<()> {
        if log_likelihoods.len() != self.points.len()
            || log_likelihoods.iter().any(|value| !is_logarithm(*value))
        {
            return Err(CalibrationError::Input(NEEDS_LOGARITHMS.into()));
        }
        self.log_likelihoods = log_likelihoods.to_vec();
        Ok(())
    }

    /// The shares of all points and their weights, which add up to one (or are all zero if no point has any likelihood).
    pub fn weighted(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let shares =
            self.points.iter().map(|point| point.iter().map(|z| share_below(*z)).collect()).collect();
        (shares, self.weights(1.0))
    }

    /// The number of equally weighted points that would tell a mean as well.
    pub fn effective(&self) -> f64 {
        effective(&self.weights(1.0))
    }

    /// The largest change of a mean by the last round, over its deviation; infinite before two rounds.
    pub fn change(&self) -> f64 {
        let [.., before, last] = self.moments.as_slice() else { return f64::INFINITY };
        let changes =
            before.iter().zip(last).map(|(before, last)| (last[0] - before[0]).abs() / last[1].max(1e-12));
        changes.fold(0.0, f64::max)
    }

    /// True if the posterior has enough points and no longer moves.
    pub fn is_settled(&self) -> bool {
        self.effective() >= self.options.final_effective && self.change() <= self.options.most_change
    }

    fn moments_now(&self) -> Vec<[f64; 2]> {
        let (shares, weights) = self.weighted();
        let moments = |k: usize| {
            let mean: f64 = shares.iter().zip(&weights).map(|(point, w)| w * point[k]).sum();
            let variance: f64 =
                shares.iter().zip(&weights).map(|(point, w)| w * (point[k] - mean).powi(2)).sum();
            [mean, variance.sqrt()]
        };
        (0..self.dimension).map(moments).collect()
    }

    /// The weights of all points with a power of the likelihood, by the mixture of all proposals.
    fn weights(&self, power: f64) -> Vec<f64> {
        let logarithms: Vec<f64> = self
            .points
            .iter()
            .zip(&self.log_likelihoods)
            .map(|(point, likelihood)| {
                power * likelihood + prior_log_density(point) - self.log_mixture(point)
            })
            .collect();
        normalised(&logarithms)
    }

    /// The logarithm of the density from which all points were drawn, taken together.
    fn log_mixture(&self, point: &[f64]) -> f64 {
        let total = self.points.len() as f64;
        let of_round = |(count, kernels): &(usize, Option<Kernels>)| {
            let density = kernels
                .as_ref()
                .map_or_else(|| prior_log_density(point), |kernels| kernels.log_density(point));
            libm::log(*count as f64 / total) + density
        };
        log_sum(self.rounds.iter().map(of_round))
    }

    /// The kernels about all points, with the largest power of the likelihood by which enough of them count.
    fn kernels(&self) -> Result<Kernels> {
        let enough = self.options.least_effective.min(0.5 * self.points.len() as f64);
        let mut weights = self.weights(1.0);
        if effective(&weights) < enough {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if effective(&self.weights(middle)) < enough { high = middle } else { low = middle }
            }
            weights = self.weights(low);
        }
        if weights.iter().all(|weight| *weight == 0.0) {
            let message =
                "no point of the prior has any likelihood; widen the errors of the curves, or the priors";
            return Err(CalibrationError::Input(message.into()));
        }
        Kernels::about(&self.points, weights, self.dimension).ok_or_else(|| {
            CalibrationError::Input("the points that count lie all in one plane; use more points".into())
        })
    }
}

impl Kernels {
    /// Kernels about weighted points, shrunk towards the mean so that the mixture has the mean and the covariance of the points.
    fn about(points: &[Vec<f64>], weights: Vec<f64>, dimension: usize) -> Option<Kernels> {
        let mean: Vec<f64> = (0..dimension)
            .map(|k| points.iter().zip(&weights).map(|(point, w)| w * point[k]).sum())
            .collect();
        let number = effective(&weights);
        let width =
            libm::pow(4.0 / (dimension as f64 + 2.0) / number, 1.0 / (dimension as f64 + 4.0)).min(0.9);
        let shrink = (1.0 - width * width).sqrt();
        let mut covariance = vec![0.0; dimension * dimension];
        for (point, weight) in points.iter().zip(&weights) {
            for i in 0..dimension {
                for j in 0..=i {
                    covariance[i * dimension + j] +=
                        weight * width * width * (point[i] - mean[i]) * (point[j] - mean[j]);
                }
            }
        }
        // A floor keeps kernels from collapsing onto a few points that happen to agree.
        (0..dimension).for_each(|k| covariance[k * dimension + k] += 1e-8);
        let factor = Cholesky::new(dimension, &covariance)?;
        let shrunk = |point: &Vec<f64>| {
            point.iter().zip(&mean).map(|(z, m)| shrink * z + (1.0 - shrink) * m).collect()
        };
        Some(Kernels {
            centres: points.iter().map(shrunk).collect(),
            weights,
            log_determinant: factor.log_determinant(),
            factor: factor.lower().to_vec(),
        })
    }

    fn log_density(&self, point: &[f64]) -> f64 {
        let Some(factor) = Cholesky::from_lower(point.len(), self.factor.clone()) else {
            return f64::NEG_INFINITY;
        };
        let constant =
            0.5 * (self.log_determinant + point.len() as f64 * libm::log(2.0 * std::f64::consts::PI));
        let term = |(centre, weight): (&Vec<f64>, &f64)| {
            let apart: Vec<f64> = point.iter().zip(centre).map(|(a, b)| a - b).collect();
            let square: f64 = factor.solve_lower(&apart).iter().map(|y| y * y).sum();
            libm::log(*weight) - 0.5 * square - constant
        };
        log_sum(self.centres.iter().zip(&self.weights).filter(|(_, weight)| **weight > 0.0).map(term))
    }
}

/// True for what a likelihood can have as its logarithm.
fn is_logarithm(value: f64) -> bool {
    value.is_finite() || value == f64::NEG_INFINITY
}

/// The logarithm of the prior's density over normal quantiles.
fn prior_log_density(point: &[f64]) -> f64 {
    let constant = 0.5 * libm::log(2.0 * std::f64::consts::PI);
    point.iter().map(|z| -0.5 * z * z - constant).sum()
}

/// The logarithm of a sum of exponentials.
fn log_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let terms: Vec<f64> = terms.collect();
    let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + libm::log(terms.iter().map(|term| libm::exp(term - largest)).sum())
}

/// Weights that add up to one, from logarithms; all zero if all are minus infinity.
fn normalised(logarithms: &[f64]) -> Vec<f64> {
    let total = log_sum(logarithms.iter().copied());
    if total == f64::NEG_INFINITY {
        return vec![0.0; logarithms.len()];
    }
    logarithms.iter().map(|value| libm::exp(value - total)).collect()
}

/// Kish's effective number of weighted points.
fn effective(weights: &[f64]) -> f64 {
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    if squares > 0.0 { 1.0 / squares } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;
    use crate::draws::chains::{ChainOptions, LogDensity, draw};

    /// A curved valley over three shares.
    fn log_likelihood(x: &[f64]) -> f64 {
        let [a, b, c] = [(x[0] - 0.3) / 0.1, (x[1] - 0.5 - 0.8 * (x[0] - 0.3)) / 0.04, (x[2] - 0.7) / 0.15];
        -0.5 * (a * a + b * b + c * c)
    }

    struct Valley(Vec<String>);

    impl LogDensity for Valley {
        fn names(&self) -> &[String] {
            &self.0
        }
        fn log_density(&self, shares: &[f64]) -> f64 {
            log_likelihood(shares)
        }
    }

    fn settled(options: SequentialOptions) -> Sequential {
        let mut rounds = Sequential::new(3, options);
        while !rounds.is_settled() {
            assert!(rounds.rounds() < 12, "{} {}", rounds.effective(), rounds.change());
            let points = rounds.propose().unwrap();
            let results: Vec<f64> = points.iter().map(|point| log_likelihood(point)).collect();
            rounds.take(&points, &results).unwrap();
        }
        rounds
    }

    #[test]
    fn rounds_and_chains_find_the_same_posterior() {
        let options =
            SequentialOptions { points: 100, final_effective: 150.0, ..SequentialOptions::default() };
        let rounds = settled(options);
        let valley = Valley(["a", "b", "c"].map(String::from).to_vec());
        let draws = draw(&valley, &ChainOptions::default(), &mut NoObserver).unwrap();
        for (k, [mean, deviation]) in rounds.moments_now().into_iter().enumerate() {
            let values: Vec<f64> = draws.shares[k].iter().flatten().copied().collect();
            let other = values.iter().sum::<f64>() / values.len() as f64;
            let spread =
                (values.iter().map(|x| (x - other).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
            assert!((mean - other).abs() < 0.3 * spread, "{k}: {mean} {other} ± {spread}");
            assert!((deviation / spread - 1.0).abs() < 0.25, "{k}: {deviation} {spread}");
        }
    }

    #[test]
    fn rounds_are_written_and_continued() {
        let rounds = settled(SequentialOptions::default());
        let text = serde_json::to_string(&rounds).unwrap();
        let mut again: Sequential = serde_json::from_str(&text).unwrap();
        assert_eq!(again, rounds);
        assert_eq!(again.propose().unwrap(), rounds.clone().propose().unwrap());
        let (_, weights) = rounds.weighted();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(again.take(&[vec![0.5; 3]], &[f64::NAN]).is_err());
        // A likelihood that is the same everywhere leaves the prior, whatever was taken before.
        assert!(again.judge_again(&[0.0]).is_err());
        again.judge_again(&vec![-1.0; weights.len()]).unwrap();
        assert!(
            again.moments_now().iter().all(|[mean, _]| (mean - 0.5).abs() < 0.1),
            "{:?}",
            again.moments_now()
        );
    }

    #[test]
    fn a_likelihood_of_zero_everywhere_is_an_error() {
        let mut rounds = Sequential::new(2, SequentialOptions::default());
        let points = rounds.propose().unwrap();
        rounds.take(&points, &vec![f64::NEG_INFINITY; points.len()]).unwrap();
        assert!(rounds.propose().unwrap_err().to_string().contains("no point of the prior"));
        assert_eq!((rounds.effective(), rounds.is_settled()), (0.0, false));
    }
}
