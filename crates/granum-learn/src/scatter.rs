//! The scatter between runs of one case.
//!
//! The reference for scores is the **seed scatter** in the same measure: for runs of the same case that differ only in their
//! seed, the unbiased standard deviation between them at each value of the coordinate, pooled over the coordinate, over the root
//! mean square of their mean. The true mean curve would have an error of one scatter on an unseen run, and the mean of n runs,
//! without any further information, an error of sqrt(1 + 1/n) times the scatter. A smaller error may merely be due to a smooth
//! curve; whether it is due to the inputs of the unseen run is tested by [`crate::input_use`].

use serde::{Deserialize, Serialize};

use crate::curve::{RunCurves, never_falls};
use crate::dataset::{RunStates, SplitParts};
use crate::error::Result;
use crate::surrogate::FitSpec;

/// The scatter between some runs along a coordinate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scatter {
    /// The scatter, relative to the root mean square of the mean.
    pub relative: f64,
    /// The coordinate of each state.
    pub coordinates: Vec<f64>,
    /// Mean over the runs at each state, one value for each column.
    pub means: Vec<Vec<f64>>,
    /// Unbiased standard deviation between the runs at each state.
    pub deviations: Vec<Vec<f64>>,
    /// Sum of the variances, and of the squares of the means, over all states and columns.
    sums: [f64; 2],
}

impl Scatter {
    /// Scatter of columns between runs, at the states of the first run within the range of the coordinate that all runs cover;
    /// the other runs are interpolated linearly between their states. `None` for fewer than two runs.
    ///
    /// # Errors
    /// If a column is missing.
    pub fn new(
        runs: &[&RunStates],
        coordinate: &str,
        columns: &[String],
        range: [f64; 2],
    ) -> Result<Option<Scatter>> {
        let curves = runs.iter().map(|run| RunCurves::new(run, coordinate, columns));
        let curves = curves.collect::<Result<Vec<_>>>()?;
        let Some((first, others)) = curves.split_first().filter(|(_, others)| !others.is_empty()) else {
            return Ok(None);
        };
        // The coordinates of states with the same number may differ by the interval between samples; the ends of the range are
        // nevertheless included.
        let slack = 1e-3 * (range[1] - range[0]);
        let low =
            others.iter().filter_map(|run| run.coordinate.first()).fold(range[0], |a, x| a.max(x - slack));
        let high =
            others.iter().filter_map(|run| run.coordinate.last()).fold(range[1], |a, x| a.min(x + slack));
        let mut scatter = Scatter::default();
        let (mut variance, mut square) = (0.0, 0.0);
        for (state, &x) in first.coordinate.iter().enumerate().filter(|(_, x)| **x >= low && **x <= high) {
            let all: Vec<Vec<f64>> =
                std::iter::once(first.row(state)).chain(others.iter().map(|run| run.at(x))).collect();
            let n = all.len() as f64;
            let means: Vec<f64> =
                (0..all[0].len()).map(|c| all.iter().map(|values| values[c]).sum::<f64>() / n).collect();
            let variances: Vec<f64> = (0..means.len())
                .map(|c| all.iter().map(|values| (values[c] - means[c]).powi(2)).sum::<f64>() / (n - 1.0))
                .collect();
            variance += variances.iter().sum::<f64>();
            square += means.iter().map(|mean| mean * mean).sum::<f64>();
            scatter.coordinates.push(x);
            scatter.deviations.push(variances.iter().map(|v| v.sqrt()).collect());
            scatter.means.push(means);
        }
        if square > 0.0 {
            scatter.relative = (variance / square).sqrt();
        }
        scatter.sums = [variance, square];
        Ok(Some(scatter))
    }
}

/// Expected error of the mean of `runs` training runs on an unseen run, in units of the seed scatter.
pub fn best_without_inputs(runs: usize) -> f64 {
    (1.0 + 1.0 / runs.max(1) as f64).sqrt()
}

/// The scatter between the runs of a study that differ only in their seed, pooled over all groups of such runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeedScatter {
    /// The scatter, relative to the root mean square of the means.
    pub relative: f64,
    /// Number of groups of two or more runs with the same parameters.
    pub groups: usize,
    /// Number of runs in these groups.
    pub runs: usize,
    /// Expected error on an unseen run of one of these groups if its mean over the training runs of the group is known and
    /// nothing else; null if no group has a training run.
    pub best_without_inputs: Option<f64>,
}

/// The seed scatter of the outputs of a fit over all runs of a data set. `None` without groups of runs that differ only in their
/// seed, or without a coordinate that never falls in all of these runs.
///
/// # Errors
/// If a column is missing.
pub fn seed_scatter(parts: &SplitParts, spec: &FitSpec) -> Result<Option<SeedScatter>> {
    let Some(coordinate) = &spec.coordinate else { return Ok(None) };
    let outputs = spec.columns(&parts.training)?.output_names();
    let training = parts.training_runs.runs().len();
    let mut groups: Vec<Vec<(usize, &RunStates)>> = Vec::new();
    for (k, run) in parts.training_runs.runs().iter().chain(parts.unseen.runs()).enumerate() {
        match groups.iter_mut().find(|group| is_same_test(group[0].1, run)) {
            Some(group) => group.push((k, run)),
            None => groups.push(vec![(k, run)]),
        }
    }
    let (mut sums, mut found, mut best, mut weight) = ([0.0; 2], SeedScatter::default(), 0.0, 0.0);
    for group in groups.iter().filter(|group| group.len() > 1) {
        let runs: Vec<&RunStates> = group.iter().map(|(_, run)| *run).collect();
        let xs = runs.iter().map(|run| run.column(coordinate)).collect::<Result<Vec<_>>>()?;
        if !xs.iter().all(|xs| never_falls(xs)) {
            return Ok(None);
        }
        let ends = |xs: &[f64]| [xs.first().copied().unwrap_or(0.0), xs.last().copied().unwrap_or(0.0)];
        let range = match (spec.sub_models.first(), spec.sub_models.last()) {
            (Some(first), Some(last)) => [first.range[0], last.range[1]],
            _ => ends(&xs[0]),
        };
        let Some(scatter) = Scatter::new(&runs, coordinate, &outputs, range)? else { continue };
        sums = [sums[0] + scatter.sums[0], sums[1] + scatter.sums[1]];
        found.groups += 1;
        found.runs += runs.len();
        let trained = group.iter().filter(|(k, _)| *k < training).count();
        if trained > 0 {
            best += scatter.sums[0] * (1.0 + 1.0 / trained as f64);
            weight += scatter.sums[1];
        }
    }
    if sums[1] <= 0.0 {
        return Ok(None);
    }
    found.relative = (sums[0] / sums[1]).sqrt();
    found.best_without_inputs = (weight > 0.0).then(|| f64::sqrt(best / weight));
    Ok(Some(found))
}

/// True if two runs have the same parameters besides their seeds and the measures of their samples.
fn is_same_test(a: &RunStates, b: &RunStates) -> bool {
    let parameters = |run: &RunStates| -> Vec<(String, String)> {
        let of_case = run
            .parameters()
            .iter()
            .filter(|found| found.key != granum_io::case::SEED && !found.key.starts_with("sample."));
        let value = |key: &str| match run.parameter(key) {
            Some(number) => format!("{number:e}"),
            None => run.word(key).unwrap_or_default(),
        };
        of_case.map(|found| (found.key.clone(), value(&found.key))).collect()
    };
    parameters(a) == parameters(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Dataset, Split};
    use crate::score::Scorer;
    use crate::synthetic::{Law, dataset_of, record, records};

    /// The error of the mean of n runs on another run is sqrt(1 + 1/n) times the scatter.
    #[test]
    fn the_scatter_is_what_a_mean_curve_scores() {
        let records: Vec<_> = (1..=12).map(|seed| record(Law::Blind, seed, 120)).collect();
        let dataset = dataset_of(&records).select(|run, row| run.table().values("state").unwrap()[row] > 0.0);
        let runs: Vec<&RunStates> = dataset.runs().iter().collect();
        let ratio = ["stress_ratio".to_string()];
        let scatter = Scatter::new(&runs, "deviator_strain", &ratio, [0.0, 0.3]).unwrap().unwrap();
        // The hidden variable is uniform in +-0.5 and enters with the factor 0.3; the noise is 0.004.
        let deviation = (0.09 / 12.0 + 0.004f64.powi(2)).sqrt();
        let mean_square =
            scatter.means.iter().map(|mean| mean[0] * mean[0]).sum::<f64>() / scatter.means.len() as f64;
        assert!((scatter.relative / (deviation / mean_square.sqrt()) - 1.0).abs() < 0.05);
        let values: Vec<Vec<f64>> = runs.iter().map(|run| run.column("stress_ratio").unwrap()).collect();
        for n in [1, 3] {
            let mut scorer = Scorer::default();
            for unseen in n..12 {
                for k in 0..values[unseen].len() {
                    let mean = values[..n].iter().map(|run| run[k]).sum::<f64>() / n as f64;
                    scorer.add(&[values[unseen][k]], &[mean]);
                }
            }
            let expected = scatter.relative * best_without_inputs(n);
            assert!((scorer.score().relative_rmse / expected - 1.0).abs() < 0.08, "{n}");
        }
    }

    #[test]
    fn scatter_needs_two_runs_and_covers_several_columns() {
        let dataset = dataset_of(&records(Law::Plain, 2));
        let runs: Vec<&RunStates> = dataset.runs().iter().collect();
        let columns = dataset.expand(&["probability_density"]).unwrap();
        let scatter =
            |runs: &[&RunStates]| Scatter::new(runs, "deviator_strain", &columns, [0.05, 0.1]).unwrap();
        assert!(scatter(&runs[..1]).is_none());
        let scatter = scatter(&runs).unwrap();
        assert_eq!(scatter.means[0].len(), columns.len());
        assert!(
            scatter.coordinates.iter().all(|s| (0.0499..=0.1001).contains(s))
                && scatter.coordinates.len() == 11
        );
        assert!(scatter.relative > 1e-4 && scatter.relative < 0.05, "{}", scatter.relative);
    }

    /// Runs of two frictions: the scatter is that within each of them, not the difference between them.
    #[test]
    fn the_seed_scatter_is_pooled_over_runs_of_equal_parameters() {
        let run = |k: u64, friction: f64, shift: f64| {
            let x: Vec<f64> = (0..20).map(f64::from).collect();
            let y = x.iter().map(|_| 10.0 * friction + shift).collect();
            let columns = vec![granum_core::Column::new("x", "", x), granum_core::Column::new("y", "", y)];
            let run = RunStates::new(&format!("run-{k}"), granum_core::Table::new(columns).unwrap()).unwrap();
            let run = run.with_parameter("friction", "", friction).unwrap();
            run.with_parameter(granum_io::case::SEED, "", k as f64).unwrap()
        };
        let runs =
            vec![run(1, 0.3, 0.1), run(2, 0.3, -0.1), run(3, 0.5, 0.1), run(4, 0.5, -0.1), run(5, 0.9, 0.0)];
        let dataset = Dataset::new(runs).unwrap();
        let spec = FitSpec::new(["x", "friction"], ["y"]).with_coordinate("x");
        let parts = dataset.split(&Split::default().unseen(["run-2", "run-5"])).unwrap();
        let found = seed_scatter(&parts, &spec).unwrap().unwrap();
        // The variance is 0.02 in both groups, the means are 3 and 5; one of the groups has one training run, the other two.
        assert_eq!((found.groups, found.runs), (2, 4));
        assert!((found.relative - (0.02f64 / 17.0).sqrt()).abs() < 1e-12, "{found:?}");
        let best = found.best_without_inputs.unwrap();
        assert!((best - (0.02f64 * (2.0 + 1.5) / 2.0 / 17.0).sqrt()).abs() < 1e-12, "{found:?}");
        let alone = dataset.select(|run, _| ["run-1", "run-3", "run-5"].contains(&run.name()));
        let alone = alone.split(&Split::default()).unwrap();
        assert_eq!(seed_scatter(&alone, &spec).unwrap(), None);
    }
}
