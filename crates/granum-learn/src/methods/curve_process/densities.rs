//! A whole distribution as few numbers, such as that of the contact forces `P(f)`.
//!
//! The share of each bin and the share beyond the bins sum to one. Their square roots are a vector of length one, and between tests it differs
//! along few directions:
//!
//! ```text
//! sqrt(m_b) = q_b + sum_j c_j v_bj,     P_b = m_b / w
//! ```
//!
//! with the mean `q`, principal directions `v_j` and the width of bins `w`. The coefficients `c_j` are curves over the coordinate as any other
//! output. Put together again, the squares are shares, none of them negative; they are divided by their sum, and tilted,
//! `m_b -> m_b exp(-t f_b)`, until the mean of the binned quantity `f` is one, as that of forces over their mean is. Square roots have
//! nearly the same scatter in every bin, so that bins with few contacts do not count less than those with many.

use serde::{Deserialize, Serialize};

use super::components::directions;
use crate::dataset::{ColumnGroup, RunStates};

/// Most directions.
const MOST: usize = 5;
/// A direction with less than this share of the variance is left out.
const LEAST_SHARE: f64 = 0.02;
/// The mean of a distribution is one if the training states agree to this standard deviation.
const MEAN_IS_ONE: f64 = 0.01;
/// Most steps of the search for a tilt.
pub(super) const STEPS: usize = 60;

/// A histogram among the outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Densities {
    /// The output that is its first bin.
    pub first: usize,
    /// Width of a bin.
    pub width: f64,
    /// Mean of the binned quantity in each bin, and beyond the bins; empty if the mean of the distribution is not known.
    pub values: Vec<f64>,
    /// Mean square root of each share, the last that beyond the bins.
    pub mean: Vec<f64>,
    /// Each with a value for each share.
    pub directions: Vec<Vec<f64>>,
    /// Variance of each square root that the directions do not contain.
    pub rest: Vec<f64>,
}

/// The density of a bin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Density {
    pub mean: f64,
    /// Variance by the parameters of the processes, and by the noise of a single run.
    pub parameters: f64,
    pub noise: f64,
}

/// A coefficient: its mean, and its variance by parameters and noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Coefficient {
    pub mean: f64,
    pub parameters: f64,
    pub noise: f64,
}

/// The histograms of which all bins are outputs, in order: the first output with the histogram.
pub(super) fn histograms_among<'a>(run: &'a RunStates, outputs: &[String]) -> Vec<(usize, &'a ColumnGroup)> {
    let mut found = Vec::new();
    for group in run.groups() {
        let names: Vec<String> = group.columns().collect();
        let first = names.first().and_then(|name| outputs.iter().position(|output| output == name));
        if let Some(first) = first
            && names.len() > 2
            && outputs[first..].starts_with(&names)
        {
            found.push((first, group));
        }
    }
    found.sort_by_key(|(first, _)| *first);
    found
}

impl Densities {
    /// From the densities of states, each with a value for each bin; `weights` says how much a state counts.
    pub fn new(group: &ColumnGroup, first: usize, states: &[Vec<f64>], weights: &[f64]) -> Densities {
        let width = group.bin_width;
        let shares: Vec<Vec<f64>> = states.iter().map(|state| shares(state, width)).collect();
        let roots: Vec<Vec<f64>> =
            shares.iter().map(|state| state.iter().map(|share| share.sqrt()).collect()).collect();
        let count = roots[0].len();
        let total: f64 = weights.iter().sum();
        let mean: Vec<f64> = (0..count).map(|k| weighted(&roots, weights, k) / total).collect();
        let scaled: Vec<Vec<f64>> = roots
            .iter()
            .zip(weights)
            .map(|(state, weight)| {
                let factor = (weight * roots.len() as f64 / total).sqrt();
                state.iter().zip(&mean).map(|(root, mean)| factor * (root - mean)).collect()
            })
            .collect();
        let directions = directions(&scaled, MOST, LEAST_SHARE);
        let mut rest = vec![0.0; count];
        for state in &scaled {
            let dot = |direction: &Vec<f64>| direction.iter().zip(state).map(|(v, d)| v * d).sum::<f64>();
            let along: Vec<f64> = directions.iter().map(dot).collect();
            for (k, variance) in rest.iter_mut().enumerate() {
                let inside: f64 = directions.iter().zip(&along).map(|(direction, c)| c * direction[k]).sum();
                *variance += (state[k] - inside).powi(2) / scaled.len() as f64;
            }
        }
        let values = values(group, &shares, weights).unwrap_or_default();
        Densities { first, width, values, mean, directions, rest }
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.mean.len().saturating_sub(1)
    }

    /// The coefficients of the densities of a state.
    pub fn coefficients(&self, densities: &[f64]) -> Vec<f64> {
        let shares = shares(densities, self.width);
        let along = |direction: &Vec<f64>| {
            let each = direction.iter().zip(&shares).zip(&self.mean);
            each.map(|((v, share), mean)| v * (share.sqrt() - mean)).sum()
        };
        self.directions.iter().map(along).collect()
    }

    /// The densities of the bins.
    pub fn densities(&self, coefficients: &[Coefficient]) -> Vec<Density> {
        let roots: Vec<Density> = (0..self.mean.len())
            .map(|k| {
                let mut root = Density { mean: self.mean[k], parameters: 0.0, noise: self.rest[k] };
                for (direction, coefficient) in self.directions.iter().zip(coefficients) {
                    let square = direction[k] * direction[k];
                    root.mean += direction[k] * coefficient.mean;
                    root.parameters += square * coefficient.parameters;
                    root.noise += square * coefficient.noise;
                }
                root
            })
            .collect();
        // The mean of a square is the square of the mean and the variance.
        let mut shares: Vec<f64> = roots.iter().map(|root| root.mean * root.mean + root.noise).collect();
        self.normalise(&mut shares);
        let of_bin = |(root, share): (&Density, &f64)| {
            // With the variance s of a normal root r, that of its square is 4 r^2 s + 2 s^2.
            let all = root.parameters + root.noise;
            let variance = (4.0 * root.mean * root.mean * all + 2.0 * all * all) / (self.width * self.width);
            let part = if all > 0.0 { root.parameters / all } else { 0.0 };
            Density { mean: share / self.width, parameters: part * variance, noise: (1.0 - part) * variance }
        };
        roots.iter().zip(&shares).take(self.bins()).map(of_bin).collect()
    }

    /// Shares with the sum one and, where it is known, the mean one.
    fn normalise(&self, shares: &mut [f64]) {
        let sum: f64 = shares.iter().sum();
        if sum <= 0.0 {
            return;
        }
        shares.iter_mut().for_each(|share| *share /= sum);
        if self.values.is_empty() {
            return;
        }
        let mut tilt = 0.0;
        for _ in 0..STEPS {
            let tilted = |(share, value): (&f64, &f64)| share * libm::exp(-tilt * (value - 1.0));
            let own: Vec<f64> = shares.iter().zip(&self.values).map(tilted).collect();
            let sum: f64 = own.iter().sum();
            let moment = |power: i32| {
                own.iter()
                    .zip(&self.values)
                    .map(|(m, v)| m * granum_simd::integer_power(v - 1.0, power))
                    .sum::<f64>()
                    / sum
            };
            let (first, second) = (moment(1), moment(2));
            if first.abs() < 1e-13 || second <= 0.0 {
                break;
            }
            // The logarithm of the sum is convex in the tilt, with this slope and this curvature.
            tilt += (first / second).clamp(-0.5, 0.5);
        }
        let exponent = |value: f64| libm::exp(-tilt * (value - 1.0));
        shares.iter_mut().zip(&self.values).for_each(|(share, value)| *share *= exponent(*value));
        let sum: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= sum);
    }

    /// True if it can be that of so many outputs.
    pub fn is_sound(&self, outputs: usize) -> bool {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        let count = self.mean.len();
        count > 1
            && self.first + self.bins() <= outputs
            && self.width > 0.0
            && self.width.is_finite()
            && finite(&self.mean)
            && finite(&self.values)
            && (self.values.is_empty() || self.values.len() == count)
            && self.rest.len() == count
            && self.rest.iter().all(|variance| *variance >= 0.0 && variance.is_finite())
            && self.directions.iter().all(|direction| direction.len() == count && finite(direction))
    }
}

/// The share of each bin and that beyond them.
fn shares(densities: &[f64], width: f64) -> Vec<f64> {
    let mut shares: Vec<f64> = densities.iter().map(|density| (density * width).max(0.0)).collect();
    let beyond = 1.0 - shares.iter().sum::<f64>();
    shares.push(beyond.max(0.0));
    shares
}

fn weighted(states: &[Vec<f64>], weights: &[f64], k: usize) -> f64 {
    states.iter().zip(weights).map(|(state, weight)| state[k] * weight).sum()
}

/// Mean of the quantity in each bin and beyond them, if the mean of all training states is one with it. Within a bin the density falls or
/// rises as that of its neighbours does: the mean is the centre and `w^2 P' / 12 P`. Beyond the bins it is the one that gives the
/// states the mean one, by least squares.
fn values(group: &ColumnGroup, shares: &[Vec<f64>], weights: &[f64]) -> Option<Vec<f64>> {
    let bins = group.centres.len();
    let total: Vec<f64> = (0..=bins).map(|k| weighted(shares, weights, k)).collect();
    let mut values = group.centres.clone();
    for k in 1..bins - 1 {
        if total[k - 1] > 0.0 && total[k] > 0.0 && total[k + 1] > 0.0 {
            let slope = (total[k + 1] - total[k - 1]) / (2.0 * group.bin_width * total[k]);
            let most = 0.5 * group.bin_width;
            values[k] += (group.bin_width * group.bin_width * slope / 12.0).clamp(-most, most);
        }
    }
    let lacking = |state: &Vec<f64>| 1.0 - values.iter().zip(state).map(|(value, m)| value * m).sum::<f64>();
    let (mut product, mut square) = (0.0, 0.0);
    for (state, weight) in shares.iter().zip(weights) {
        product += weight * lacking(state) * state[bins];
        square += weight * state[bins] * state[bins];
    }
    // Where next to nothing is beyond the bins, it could be anywhere.
    let (least, most) = (group.centres[0], group.centres[bins - 1]);
    let range = most - least;
    let beyond = if square > 0.0 { (product / square).clamp(least - range, most + range) } else { most };
    let each = shares.iter().zip(weights);
    let error =
        each.map(|(state, weight)| weight * (lacking(state) - beyond * state[bins]).powi(2)).sum::<f64>();
    values.push(beyond);
    ((error / weights.iter().sum::<f64>()).sqrt() < MEAN_IS_ONE).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: f64 = 0.25;

    /// Exponential distributions that begin at `start`, with the mean one, exact in each bin.
    fn exponential(start: f64) -> Vec<f64> {
        let above = |f: f64| if f <= start { 1.0 } else { (-(f - start) / (1.0 - start)).exp() };
        (0..24).map(|k| f64::from(k) * WIDTH).map(|f| (above(f) - above(f + WIDTH)) / WIDTH).collect()
    }

    fn group() -> ColumnGroup {
        let centres = (0..24).map(|k| (f64::from(k) + 0.5) * WIDTH).collect();
        ColumnGroup { name: "probability_density".into(), binned: "force".into(), bin_width: WIDTH, centres }
    }

    fn learned() -> Densities {
        let states: Vec<Vec<f64>> = (0..=20).map(|k| exponential(f64::from(k) / 50.0)).collect();
        Densities::new(&group(), 0, &states, &vec![1.0; states.len()])
    }

    #[test]
    fn distributions_are_normalised_positive_and_have_the_mean_one_for_any_coefficients() {
        let densities = learned();
        assert_eq!(densities.values.len(), 25);
        // The forces beyond 6 of such a distribution are 0.6 to 1 above it on average; they are few, and bins are not exact.
        assert!((6.0..10.0).contains(&densities.values[24]), "{}", densities.values[24]);
        for shift in [-0.6, -0.05, 0.0, 0.07, 0.9] {
            let coefficient =
                |k: usize| Coefficient { mean: shift / (1.0 + k as f64), noise: 1e-4, parameters: 1e-4 };
            let coefficients: Vec<Coefficient> = (0..densities.directions.len()).map(coefficient).collect();
            let found = densities.densities(&coefficients);
            let shares: Vec<f64> = found.iter().map(|density| density.mean * WIDTH).collect();
            let beyond = 1.0 - shares.iter().sum::<f64>();
            assert!(
                beyond > -1e-12 && shares.iter().all(|share| *share >= 0.0),
                "{shift}: {beyond} {shares:?}"
            );
            let mean: f64 = shares.iter().chain([&beyond]).zip(&densities.values).map(|(m, v)| m * v).sum();
            assert!((mean - 1.0).abs() < 1e-10, "{shift}: {mean}");
        }
    }

    #[test]
    fn a_distribution_is_given_back_by_its_coefficients() {
        let densities = learned();
        let state = exponential(0.13);
        let exact = |mean: f64| Coefficient { mean, ..Coefficient::default() };
        let coefficients: Vec<Coefficient> = densities.coefficients(&state).into_iter().map(exact).collect();
        let back = densities.densities(&coefficients);
        let error: f64 = back.iter().zip(&state).map(|(a, b)| (a.mean - b).abs() * WIDTH).sum();
        assert!(error < 0.02, "{error} of 2");
        // A distribution with another mean is not forced to one.
        let far: Vec<Vec<f64>> =
            (0..9).map(|k| exponential(0.05 * f64::from(k)).into_iter().rev().collect()).collect();
        assert!(Densities::new(&group(), 0, &far, &[1.0; 9]).values.is_empty());
    }
}
