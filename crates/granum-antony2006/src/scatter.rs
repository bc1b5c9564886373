//! The scatter between runs of one case.
//!
//! The reference for scores is the **seed scatter** in the same measure: for runs of the same case that differ only in their
//! seed, the unbiased standard deviation between them at each strain, pooled over strain, over the root mean square of their
//! mean. The true mean curve would have an error of one scatter on an unseen run, and the mean of n runs, without any
//! further information, an error of sqrt(1 + 1/n) times the scatter. A smaller error may merely be due to a smooth curve;
//! whether it is due to the sensors of the unseen run is tested by [`crate::sensor_use`].

use crate::mapping::Quantity;
use crate::study_data::{Run, State};

/// The scatter between runs that differ only in their seed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scatter {
    /// Seed scatter, relative to the root mean square of the mean.
    pub relative: f64,
    /// Strain of each state.
    pub strains: Vec<f64>,
    /// Mean over the runs at each state, one value for each component of the quantity.
    pub means: Vec<Vec<f64>>,
    /// Unbiased standard deviation between the runs at each state.
    pub deviations: Vec<Vec<f64>>,
}

impl Scatter {
    /// Scatter of a quantity between runs, at the states of the first run within the range of strain that all runs cover;
    /// the other runs are interpolated linearly between their states. `None` for fewer than two runs.
    pub fn new(quantity: Quantity, runs: &[&Run], range: [f64; 2]) -> Option<Scatter> {
        let (first, others) = runs.split_first()?;
        if others.is_empty() {
            return None;
        }
        // The strain of states with the same number may differ by the interval between samples; the ends of the range are
        // nevertheless included.
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

/// Expected error of the mean of `runs` training runs on an unseen run, in units of the seed scatter.
pub fn best_without_sensors(runs: usize) -> f64 {
    (1.0 + 1.0 / runs.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study_data::{StudyData, StudyDataOptions};
    use crate::synthetic::{Law, record};
    use granum_learn::dataset::NamedRecord;
    use granum_learn::score::Scorer;

    /// The error of the mean of n runs on another run is sqrt(1 + 1/n) times the scatter.
    #[test]
    fn the_scatter_is_what_a_mean_curve_scores() {
        let records: Vec<_> = (1..=12).map(|seed| record(Law::Blind, seed, 120)).collect();
        let named: Vec<NamedRecord> =
            records.iter().map(|record| NamedRecord { name: "run", seed: 0, record }).collect();
        let dataset = StudyData::new(&named, &[], &StudyDataOptions::default()).unwrap();
        let runs: Vec<&Run> = dataset.training_runs.iter().collect();
        let scatter = Scatter::new(Quantity::StressRatio, &runs, [0.0, 0.3]).unwrap();
        // The hidden variable is uniform in +-0.5 and enters with the factor 0.3; the noise is 0.004.
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
        let dataset = StudyData::new(&named, &[], &StudyDataOptions::default()).unwrap();
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
