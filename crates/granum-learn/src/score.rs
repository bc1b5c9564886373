//! How good an answer is.
//!
//! The headline is the **relative RMSE**: the root mean square error over the root mean square of the DEM values,
//! `sqrt(sum (answer - dem)^2 / sum dem^2)` over every value of every scored state. It does not blow up where a curve
//! is flat, as `R2 = 1 - sum (answer - dem)^2 / sum (dem - mean dem)^2` does; R2 is given beside. A state with a
//! distribution counts with each of its bins.
//!
//! The yardstick is the **seed scatter**, in the same measure: runs of the same case that differ in their seed alone,
//! the unbiased standard deviation between them at each strain, pooled over strain, over the root mean square of their
//! mean. Who knew the true mean curve would score 1 times the scatter against an unseen run; who repeated the mean of n
//! runs, and knew nothing else, sqrt(1 + 1/n) times. An answer below that may be a smooth curve only: whether it comes of
//! the sensors of the unseen run is told by [`crate::sensor_use`].

use serde::{Deserialize, Serialize};

use crate::dataset::{Run, State};
use crate::mapping::Quantity;

/// How good an answer is against DEM.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Root mean square error over the root mean square of the DEM values.
    pub relative_rmse: f64,
    /// Coefficient of determination.
    pub r2: f64,
    /// Root mean square error in the unit of the output.
    pub rmse: f64,
    /// Number of states scored.
    pub states: usize,
}

/// Adds up errors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scorer {
    states: usize,
    values: usize,
    errors: f64,
    squares: f64,
    sum: f64,
}

impl Scorer {
    /// Adds one state: its DEM values and the answer.
    pub fn add(&mut self, dem: &[f64], answer: &[f64]) {
        self.states += 1;
        for (&exact, &value) in dem.iter().zip(answer) {
            self.values += 1;
            self.errors += (value - exact) * (value - exact);
            self.squares += exact * exact;
            self.sum += exact;
        }
    }

    /// The score; all 0 of nothing. R2 is 0 where the DEM values do not differ.
    pub fn score(&self) -> Score {
        if self.values == 0 {
            return Score::default();
        }
        let n = self.values as f64;
        let about_mean = self.squares - self.sum * self.sum / n;
        let flat = about_mean <= 1e-14 * self.squares;
        Score {
            relative_rmse: if self.squares == 0.0 { 0.0 } else { (self.errors / self.squares).sqrt() },
            r2: if flat { 0.0 } else { 1.0 - self.errors / about_mean },
            rmse: (self.errors / n).sqrt(),
            states: self.states,
        }
    }
}

/// What runs that differ in their seed alone differ by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scatter {
    /// Seed scatter, relative to the root mean square of the mean.
    pub relative: f64,
    /// Strain of each state.
    pub strains: Vec<f64>,
    /// Mean over the runs at each state, one value a component of the quantity.
    pub means: Vec<Vec<f64>>,
    /// Unbiased standard deviation between the runs at each state.
    pub deviations: Vec<Vec<f64>>,
}

impl Scatter {
    /// Scatter of a quantity between runs at the states of the first run within a range of strain that all runs
    /// cover; the other runs are taken linear between their states. `None` of fewer than two runs.
    pub fn new(quantity: Quantity, runs: &[&Run], range: [f64; 2]) -> Option<Scatter> {
        let (first, others) = runs.split_first()?;
        if others.is_empty() {
            return None;
        }
        // States of one number may differ in strain by a stride of looks; the ends are kept all the same.
        let slack = 1e-3 * (range[1] - range[0]);
        let low =
            others.iter().filter_map(|run| run.states.first()).fold(range[0], |a, s| a.max(s.strain - slack));
        let high =
            others.iter().filter_map(|run| run.states.last()).fold(range[1], |a, s| a.min(s.strain + slack));
        let mut scatter = Scatter::default();
        let (mut variance, mut square) = (0.0, 0.0);
        for state in first.states.iter().filter(|state| state.strain >= low && state.strain <= high) {
            let at: Vec<State> = others.iter().filter_map(|run| run.at(state.strain)).collect();
            let all: Vec<&[f64]> =
                std::iter::once(state).chain(&at).map(|state| state.values(quantity)).collect();
            let n = all.len() as f64;
            let means: Vec<f64> =
                (0..all[0].len()).map(|c| all.iter().map(|values| values[c]).sum::<f64>() / n).collect();
            let variances: Vec<f64> = (0..means.len())
                .map(|c| all.iter().map(|values| (values[c] - means[c]).powi(2)).sum::<f64>() / (n - 1.0))
                .collect();
            variance += variances.iter().sum::<f64>();
            square += means.iter().map(|mean| mean * mean).sum::<f64>();
            scatter.strains.push(state.strain);
            scatter.deviations.push(variances.iter().map(|v| v.sqrt()).collect());
            scatter.means.push(means);
        }
        if square > 0.0 {
            scatter.relative = (variance / square).sqrt();
        }
        Some(scatter)
    }
}

/// Score that the mean of `runs` training runs would have against an unseen run, in units of the seed scatter.
pub fn best_without_sensors(runs: usize) -> f64 {
    (1.0 + 1.0 / runs.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Dataset, DatasetOptions, NamedRecord};
    use crate::synthetic::{Law, record};

    #[test]
    fn scores_of_a_known_answer() {
        let mut scorer = Scorer::default();
        scorer.add(&[3.0], &[3.3]);
        scorer.add(&[4.0], &[3.6]);
        let score = scorer.score();
        assert!((score.relative_rmse - (0.25f64 / 25.0).sqrt()).abs() < 1e-12);
        assert!((score.rmse - 0.125f64.sqrt()).abs() < 1e-12);
        assert!((score.r2 - (1.0 - 0.25 / 0.5)).abs() < 1e-12);
        assert_eq!(score.states, 2);
        assert_eq!(Scorer::default().score(), Score::default());
        let mut flat = Scorer::default();
        flat.add(&[2.0], &[2.1]);
        assert_eq!(flat.score().r2, 0.0);
    }

    /// The mean of n runs scores sqrt(1 + 1/n) times the scatter against another run.
    #[test]
    fn the_scatter_is_what_a_mean_curve_scores() {
        let records: Vec<_> = (1..=12).map(|seed| record(Law::Blind, seed, 120)).collect();
        let named: Vec<NamedRecord> =
            records.iter().map(|record| NamedRecord { name: "run", seed: 0, record }).collect();
        let dataset = Dataset::new(&named, &[], &DatasetOptions::default()).unwrap();
        let runs: Vec<&Run> = dataset.training_runs.iter().collect();
        let scatter = Scatter::new(Quantity::StressRatio, &runs, [0.0, 0.3]).unwrap();
        // Hidden variable uniform in +-0.5 times 0.3, noise 0.004.
        let deviation = (0.09 / 12.0 + 0.004f64.powi(2)).sqrt();
        let mean_square =
            scatter.means.iter().map(|mean| mean[0] * mean[0]).sum::<f64>() / scatter.means.len() as f64;
        assert!((scatter.relative / (deviation / mean_square.sqrt()) - 1.0).abs() < 0.05);
        for n in [1, 3] {
            let mut scorer = Scorer::default();
            for unseen in n..12 {
                for (k, state) in runs[unseen].states.iter().enumerate() {
                    let mean = runs[..n].iter().map(|run| run.states[k].stress_ratio).sum::<f64>() / n as f64;
                    scorer.add(&[state.stress_ratio], &[mean]);
                }
            }
            let expected = scatter.relative * best_without_sensors(n);
            assert!((scorer.score().relative_rmse / expected - 1.0).abs() < 0.08, "{n}");
        }
    }

    #[test]
    fn scatter_needs_two_runs_and_covers_distributions() {
        let records: Vec<_> = (1..=2).map(|seed| record(Law::Plain, seed, 40)).collect();
        let named: Vec<NamedRecord> =
            records.iter().map(|record| NamedRecord { name: "run", seed: 0, record }).collect();
        let dataset = Dataset::new(&named, &[], &DatasetOptions::default()).unwrap();
        let runs: Vec<&Run> = dataset.training_runs.iter().collect();
        assert!(Scatter::new(Quantity::StressRatio, &runs[..1], [0.0, 0.3]).is_none());
        let scatter = Scatter::new(Quantity::ForceDistribution, &runs, [0.05, 0.1]).unwrap();
        assert_eq!(scatter.means[0].len(), 14);
        assert!(
            scatter.strains.iter().all(|&s| (0.0499..=0.1001).contains(&s)) && scatter.strains.len() == 7
        );
        assert!(scatter.relative > 1e-4 && scatter.relative < 0.05, "{}", scatter.relative);
    }
}
