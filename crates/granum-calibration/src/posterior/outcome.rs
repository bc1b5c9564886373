//! The posterior as values of the parameters: its table, draws from it, and a file for ArviZ.

use std::collections::BTreeMap;

use granum_core::{Column, Table};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::compared::curve::MeasuredCurve;
use crate::draws::chains::Draws;
use crate::draws::diagnostics::{Agreement, quantile_of_sorted};
use crate::draws::random::{stream, unit};
use crate::error::Result;
use crate::inference::likelihood::Posterior;
use crate::inference::prior::Prior;

/// Draws of equal weight that stand for weighted points.
const RESAMPLED: usize = 2000;

/// A posterior that has been found: values of the coordinates, which are the parameters and the relative sizes of discrepancies if these were
/// free as well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Names of the coordinates.
    pub names: Vec<String>,
    /// For each coordinate and chain, the values.
    pub values: Vec<Vec<Vec<f64>>>,
    /// For each chain, the logarithm of the likelihood.
    pub log_likelihoods: Vec<Vec<f64>>,
    /// For each coordinate how well the chains agree; empty for weighted points.
    pub agreement: Vec<Agreement>,
}

impl Outcome {
    /// From draws of chains.
    pub fn from_draws(posterior: &Posterior, draws: &Draws) -> Outcome {
        let value = |k: usize, share: &f64| posterior.value(k, *share);
        let of_chain = |k: usize, shares: &Vec<f64>| shares.iter().map(|share| value(k, share)).collect();
        let coordinate =
            |(k, chains): (usize, &Vec<Vec<f64>>)| chains.iter().map(|shares| of_chain(k, shares)).collect();
        Outcome {
            names: draws.names.clone(),
            values: draws.shares.iter().enumerate().map(coordinate).collect(),
            log_likelihoods: draws.log_densities.clone(),
            agreement: draws.agreement.clone(),
        }
    }

    /// From weighted points, of which as many draws of equal weight are taken by systematic resampling, as one chain.
    pub fn from_weighted(
        names: Vec<String>,
        priors: &[Prior],
        points: &[Vec<f64>],
        weights: &[f64],
        seed: u64,
    ) -> Outcome {
        let mut chosen = Vec::with_capacity(RESAMPLED);
        let (mut sum, mut at) = (0.0, 0);
        let first = unit(&mut stream(seed, 11));
        for k in 0..RESAMPLED {
            let wanted = (k as f64 + first) / RESAMPLED as f64;
            while at + 1 < weights.len() && sum + weights[at] < wanted {
                sum += weights[at];
                at += 1;
            }
            chosen.push(at);
        }
        let values = |k: usize, prior: &Prior| {
            vec![
                chosen
                    .iter()
                    .filter_map(|point| points.get(*point))
                    .map(|point| prior.value(point[k]))
                    .collect(),
            ]
        };
        Outcome {
            names,
            values: priors.iter().enumerate().map(|(k, prior)| values(k, prior)).collect(),
            log_likelihoods: vec![vec![0.0; RESAMPLED]],
            agreement: Vec::new(),
        }
    }

    /// All values of a coordinate, rising.
    pub fn sorted(&self, coordinate: usize) -> Vec<f64> {
        let mut all: Vec<f64> = self.values[coordinate].iter().flatten().copied().collect();
        all.sort_by(f64::total_cmp);
        all
    }

    /// Number of draws of all chains.
    pub fn len(&self) -> usize {
        self.values.first().map_or(0, |chains| chains.iter().map(Vec::len).sum())
    }

    /// True if there is no draw.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A draw: the values of all coordinates.
    pub fn draw(&self, number: usize) -> Vec<f64> {
        let of_coordinate =
            |chains: &Vec<Vec<f64>>| chains.iter().flatten().nth(number).copied().unwrap_or(f64::NAN);
        self.values.iter().map(of_coordinate).collect()
    }

    /// So many draws, spread evenly over all chains.
    pub fn spread(&self, count: usize) -> Vec<Vec<f64>> {
        let all = self.len();
        let count = count.min(all);
        (0..count).map(|k| self.draw((2 * k + 1) * all / (2 * count))).collect()
    }

    /// The mean of each coordinate.
    pub fn mean(&self) -> Vec<f64> {
        let mean = |chains: &Vec<Vec<f64>>| {
            let all: Vec<f64> = chains.iter().flatten().copied().collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        self.values.iter().map(mean).collect()
    }

    /// A row for each coordinate: mean, standard deviation, quantiles of 5, 50 and 95 %, those of the prior, and how well the chains
    /// agree (not finite for weighted points). `units` are those of the first coordinates.
    ///
    /// # Errors
    /// If the columns do not make a table.
    pub fn table(&self, priors: &[Prior], units: &[String]) -> Result<Table> {
        let count = self.names.len();
        let sorted: Vec<Vec<f64>> = (0..count).map(|k| self.sorted(k)).collect();
        let mean = self.mean();
        let deviation = |k: usize| {
            let square: f64 = sorted[k].iter().map(|x| (x - mean[k]) * (x - mean[k])).sum();
            (square / sorted[k].len() as f64).sqrt()
        };
        let column =
            |name: &str, value: &dyn Fn(usize) -> f64| Column::new(name, "", (0..count).map(value).collect());
        let agreement =
            |k: usize, value: fn(&Agreement) -> f64| self.agreement.get(k).map_or(f64::NAN, value);
        let prior = |k: usize, share: f64| priors.get(k).map_or(f64::NAN, |prior| prior.value(share));
        let units: Vec<String> = (0..count).map(|k| units.get(k).cloned().unwrap_or_default()).collect();
        let columns = vec![
            Column::of_words("parameter", self.names.clone()),
            Column::of_words("unit", units),
            column("mean", &|k| mean[k]),
            column("standard_deviation", &deviation),
            column("quantile_5", &|k| quantile_of_sorted(&sorted[k], 0.05)),
            column("median", &|k| quantile_of_sorted(&sorted[k], 0.5)),
            column("quantile_95", &|k| quantile_of_sorted(&sorted[k], 0.95)),
            column("prior_quantile_5", &|k| prior(k, 0.05)),
            column("prior_quantile_95", &|k| prior(k, 0.95)),
            column("r_hat", &|k| agreement(k, |a| a.r_hat)),
            column("effective_bulk", &|k| agreement(k, |a| a.bulk)),
            column("effective_tail", &|k| agreement(k, |a| a.tail)),
        ];
        Ok(Table::new(columns).map_err(granum_learn::LearnError::from)?)
    }

    /// A document that `arviz.from_json` reads: the groups `posterior`, `sample_stats`, and `observed_data` with the measured curves by
    /// test and quantity.
    pub fn inference_data(&self, curves: &[MeasuredCurve]) -> Value {
        let posterior: BTreeMap<&str, &Vec<Vec<f64>>> =
            self.names.iter().map(String::as_str).zip(&self.values).collect();
        let name = |curve: &MeasuredCurve| format!("{}_{}", curve.quantity, curve.test);
        let observed: BTreeMap<String, &Vec<f64>> =
            curves.iter().map(|curve| (name(curve), &curve.measured)).collect();
        json!({
            "posterior": posterior,
            "sample_stats": { "lp": self.log_likelihoods },
            "observed_data": observed,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighted_points_become_draws_of_equal_weight() {
        let prior = Prior::Uniform { from: 0.0, to: 10.0 };
        let points = [vec![0.1], vec![0.5], vec![0.9]];
        let outcome = Outcome::from_weighted(vec!["a".into()], &[prior], &points, &[0.25, 0.75, 0.0], 1);
        let sorted = outcome.sorted(0);
        let low = sorted.iter().filter(|x| **x < 2.0).count();
        assert!(low.abs_diff(500) <= 1 && sorted.iter().all(|x| *x < 6.0), "{low}");
        assert!((outcome.mean()[0] - 4.0).abs() < 0.01);
        let table = outcome.table(&[prior], &["Pa".into()]).unwrap();
        assert_eq!(table.values("prior_quantile_95").unwrap(), [9.5]);
        assert_eq!(table.values("median").unwrap(), [5.0]);
        assert_eq!(outcome.spread(4).len(), 4);
        let document = outcome.inference_data(&[]);
        assert_eq!(document["posterior"]["a"][0].as_array().unwrap().len(), 2000);
    }
}
