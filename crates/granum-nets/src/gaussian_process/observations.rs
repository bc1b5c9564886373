//! Where further observations would tell most: rows are chosen one after another, each with what the ones before it will tell.
//!
//! An observation at row `i` reduces the covariance of a process at rows `j` and `k`, whatever value it turns out to have, to
//!
//! ```text
//! C_jk - C_ij C_ik / (C_ii + n)
//! ```
//!
//! with the variance `n` of the noise. The row is taken that reduces the variance most on average over all rows, summed over processes
//! with their weights; then the covariances are those after it, so that the next one is not chosen beside it.
//!
//! Source: Cohn, Neural network exploration using optimal experiment design, Neural Networks 9 (1996), 1071 to 1083.

use super::process::GaussianProcess;
use super::rows::Rows;

/// The covariance of a process at rows, given all that was observed.
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorCovariance {
    count: usize,
    /// Row-major.
    values: Vec<f64>,
    noise: f64,
}

impl PosteriorCovariance {
    /// From the covariances of all pairs of rows, in row-major order, and the variance of the noise of an observation.
    pub(super) fn new(values: Vec<f64>, count: usize, noise: f64) -> PosteriorCovariance {
        PosteriorCovariance { count, values, noise }
    }

    /// The mean of the variance over the rows.
    pub fn mean_variance(&self) -> f64 {
        (0..self.count).map(|k| self.values[k * self.count + k]).sum::<f64>() / self.count.max(1) as f64
    }

    fn row(&self, k: usize) -> &[f64] {
        &self.values[k * self.count..(k + 1) * self.count]
    }

    /// Variance of an observation at a row; nothing is learned where there is none.
    fn observed(&self, k: usize) -> f64 {
        self.row(k)[k] + self.noise
    }

    /// By how much an observation at a row would reduce the mean of the variance over the rows.
    pub fn gain(&self, k: usize) -> f64 {
        let variance = self.observed(k);
        if variance <= 0.0 {
            return 0.0;
        }
        self.row(k).iter().map(|c| c * c).sum::<f64>() / (variance * self.count as f64)
    }

    /// The covariance after an observation at a row.
    pub fn observe(&mut self, k: usize) {
        let variance = self.observed(k);
        if variance <= 0.0 {
            return;
        }
        let with = self.row(k).to_vec();
        for (row, own) in self.values.chunks_exact_mut(self.count).zip(&with) {
            let factor = own / variance;
            row.iter_mut().zip(&with).for_each(|(value, c)| *value -= factor * c);
        }
    }
}

/// Rows in the order in which they are worth being observed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observations {
    /// The rows, the one that tells most first.
    pub rows: Vec<usize>,
    /// The weighted mean of the variance over all rows before any of them, and after each.
    pub variance: Vec<f64>,
}

impl Observations {
    /// Chooses at most `count` of the rows for which `is_free` is true, each at most once, by the processes with their weights. A row that one of
    /// the processes does not have is not chosen.
    pub fn choose(
        mut processes: Vec<(f64, PosteriorCovariance)>,
        is_free: &[bool],
        count: usize,
    ) -> Observations {
        let known = processes.iter().map(|(_, own)| own.count).min().unwrap_or(0);
        let mut is_free = is_free[..known.min(is_free.len())].to_vec();
        let mean = |processes: &[(f64, PosteriorCovariance)]| -> f64 {
            processes.iter().map(|(weight, own)| weight * own.mean_variance()).sum()
        };
        let mut found = Observations { rows: Vec::new(), variance: vec![mean(&processes)] };
        while found.rows.len() < count {
            let gain = |k: usize| processes.iter().map(|(weight, own)| weight * own.gain(k)).sum::<f64>();
            let open = (0..is_free.len()).filter(|k| is_free[*k]).map(|k| (gain(k), k));
            // Of equal gains the first row.
            let Some((_, best)) = open.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))) else { break };
            processes.iter_mut().for_each(|(_, own)| own.observe(best));
            is_free[best] = false;
            found.rows.push(best);
            found.variance.push(mean(&processes));
        }
        found
    }
}

impl GaussianProcess {
    /// The covariance of the function at rows, given the targets.
    ///
    /// # Panics
    /// If the rows have another number of inputs.
    pub fn posterior_covariance(&self, rows: &Rows) -> PosteriorCovariance {
        let further: Vec<_> = (0..rows.count()).map(|k| self.further(rows.row(k))).collect();
        let count = rows.count();
        let mut values = vec![0.0; count * count];
        for i in 0..count {
            let with = self.covariances(rows.row(i));
            for j in 0..=i {
                let covariance = self.remaining(rows.row(i), &with, &further[j]);
                (values[i * count + j], values[j * count + i]) = (covariance, covariance);
            }
        }
        PosteriorCovariance::new(values, count, self.noise())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::FitOptions;
    use super::*;

    /// A function of two inputs, observed at five places.
    fn process() -> GaussianProcess {
        let places = [[-1.0, 0.0], [-0.8, 0.3], [-0.9, -0.4], [-1.1, 0.2], [-0.7, -0.1]];
        let targets = places.map(|[x, y]: [f64; 2]| (2.0 * x).sin() + 0.5 * y);
        let rows = Rows::new(places.concat(), 2).unwrap();
        GaussianProcess::fit(Arc::new(rows), &targets, &FitOptions::default()).unwrap()
    }

    fn asked() -> Rows {
        let places = (0..25).flat_map(|k| [f64::from(k % 5) * 0.5 - 1.0, f64::from(k / 5) * 0.5 - 1.0]);
        Rows::new(places.collect(), 2).unwrap()
    }

    /// The diagonal is the variance of a prediction, and the gain is the mean of what the process itself says.
    #[test]
    fn gains_are_those_of_the_process() {
        let (process, rows) = (process(), asked());
        let found = process.posterior_covariance(&rows);
        for k in [0, 7, 24] {
            let variance = process.predict(rows.row(k)).variance;
            assert!((found.row(k)[k] - variance).abs() < 1e-9 * (1.0 + variance));
            let further = process.further(rows.row(k));
            let mean = (0..25).map(|j| process.reduction(rows.row(j), &further)).sum::<f64>() / 25.0;
            assert!((found.gain(k) - mean).abs() < 1e-9 * (1.0 + mean), "{} {mean}", found.gain(k));
        }
        // What an observation is said to reduce is what it reduces.
        let (mut after, gain) = (found.clone(), found.gain(12));
        after.observe(12);
        assert!((found.mean_variance() - after.mean_variance() - gain).abs() < 1e-12);
    }

    /// The first row lies where nothing was observed, the next ones not beside it, and no row comes twice.
    #[test]
    fn a_batch_does_not_cluster() {
        let (process, rows) = (process(), asked());
        let covariance = process.posterior_covariance(&rows);
        let is_free: Vec<bool> = (0..25).map(|k| k != 24).collect();
        let found = Observations::choose(vec![(2.0, covariance.clone())], &is_free, 4);
        assert_eq!(found.rows.len(), 4);
        assert!(found.variance.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", found.variance);
        assert!((found.variance[0] - 2.0 * covariance.mean_variance()).abs() < 1e-12);
        assert!(rows.row(found.rows[0])[0] > 0.0, "{found:?}");
        let apart = |a: usize, b: usize| {
            rows.row(a).iter().zip(rows.row(b)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
        };
        assert!(apart(found.rows[0], found.rows[1]) > 0.9, "{found:?}");
        // Those that tell most one by one are neighbours.
        let mut order: Vec<usize> = (0..24).collect();
        order.sort_by(|a, b| covariance.gain(*b).total_cmp(&covariance.gain(*a)));
        assert!(apart(order[0], order[1]) < 0.9, "{order:?}");
        let all = Observations::choose(vec![(1.0, covariance)], &is_free, 100).rows;
        let mut sorted = all.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..24).collect::<Vec<_>>());
    }
}
