//! Runs that are alike but for the seed of their samples, and how far predictions are from their mean.
//!
//! The mean of `n` replicates scatters about the material, where a single run scatters by `s`. A prediction whose errors have the mean `e` over
//! the replicates, and scatter by `r` from one to another, therefore misses the material by
//!
//! ```text
//! net = sqrt(max(0, <e^2> - <r^2> / n)) / sqrt(<s^2>)
//! ```
//!
//! times the scatter of a single run, with means over the states of all points. One more run misses it by 1. Where a prediction does not depend
//! on the sample, `r` is `s`; where it does, as on the void ratio, it is the part of the scatter that the sample does not tell.

use granum_io::case::{ParameterValue, SEED};

use crate::dataset::RunStates;

/// The beginning of the names of what was measured on the sample.
const SAMPLE: &str = "sample.";

/// The numbers of the runs that are alike, in the order in which they first occur.
pub(super) fn replicates(runs: &[&RunStates]) -> Vec<Vec<usize>> {
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let mut keys: Vec<String> = run
            .parameters()
            .iter()
            .filter(|found| found.key != SEED && !found.key.starts_with(SAMPLE))
            .map(|found| match &found.value {
                ParameterValue::Number(number) => format!("{}={:x}", found.key, number.to_bits()),
                ParameterValue::Word(word) => format!("{}={word}", found.key),
                ParameterValue::List(numbers) => format!("{}={numbers:?}", found.key),
            })
            .collect();
        keys.sort();
        let key = keys.join("\n");
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, group)) => group.push(number),
            None => groups.push((key, vec![number])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Sums over the states of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PointSums {
    /// Square of the error against the mean of the replicates.
    pub error: f64,
    /// Variance of a single run.
    pub variance: f64,
    /// Variance of the mean error over the replicates.
    pub of_mean: f64,
    /// Square of that mean.
    pub square: f64,
}

impl PointSums {
    /// Adds a state: its measured and its predicted values in each of the replicates, and how much it counts.
    pub fn add(&mut self, measured: &[f64], predicted: &[f64], share: f64) {
        let count = measured.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
        let (centre, answer) = (mean(measured), mean(predicted));
        let variance_of = |values: &[f64], mean: f64| {
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)
        };
        let errors: Vec<f64> = predicted.iter().zip(measured).map(|(answer, exact)| answer - exact).collect();
        let variance = variance_of(measured, centre);
        let of_mean = variance_of(&errors, answer - centre) / count;
        self.error += share * (answer - centre).powi(2);
        self.variance += share * variance;
        self.of_mean += share * of_mean;
        self.square += share * centre * centre;
    }
}

/// The error net of the scatter of the mean, over the scatter of a single run; 0 if the scatter explains all of it.
pub(super) fn net_error(points: &[PointSums]) -> f64 {
    let sum = |part: fn(&PointSums) -> f64| points.iter().map(part).sum::<f64>();
    let variance = sum(|point| point.variance);
    if variance <= 0.0 {
        return 0.0;
    }
    ((sum(|point| point.error) - sum(|point| point.of_mean)).max(0.0) / variance).sqrt()
}

/// The standard error of [`net_error`] by leaving out one point after the other (jackknife).
pub(super) fn standard_error(points: &[PointSums]) -> f64 {
    let count = points.len();
    if count < 2 {
        return f64::NAN;
    }
    let without = |left: usize| {
        let others: Vec<PointSums> =
            points.iter().enumerate().filter(|(k, _)| *k != left).map(|(_, point)| *point).collect();
        net_error(&others)
    };
    let all: Vec<f64> = (0..count).map(without).collect();
    let mean = all.iter().sum::<f64>() / count as f64;
    let squares = all.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    ((count as f64 - 1.0) / count as f64 * squares).sqrt()
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};

    use super::*;

    #[test]
    fn runs_that_differ_in_seed_and_sample_are_replicates() {
        let run = |name: &str, friction: f64, seed: f64| {
            let table = Table::new(vec![Column::new("x", "", vec![0.0])]).unwrap();
            let run = RunStates::new(name, table).unwrap().with_parameter("friction", "", friction).unwrap();
            let run = run.with_parameter("preparation.seed", "", seed).unwrap();
            run.with_parameter("sample.void_ratio", "", 0.6 + 0.01 * seed).unwrap()
        };
        let runs = [run("a", 0.3, 1.0), run("b", 0.4, 2.0), run("c", 0.3, 3.0)];
        assert_eq!(replicates(&runs.iter().collect::<Vec<_>>()), [vec![0, 2], vec![1]]);
    }

    /// Replicates scatter by 1 about the material, and the answer misses it by 0.5: against their mean it misses by more.
    #[test]
    fn the_scatter_of_the_mean_is_no_error_of_the_answer() {
        let mut points = Vec::new();
        for k in 0..400u32 {
            // Eight values with mean zero and variance one, shifted by the error of a mean of eight, of either sign.
            let shift = if k % 2 == 0 { 1.0 } else { -1.0 } / 8.0f64.sqrt();
            let measured: Vec<f64> =
                (0..8).map(|i| shift + (f64::from(i) - 3.5) * (7.0f64 / 42.0).sqrt()).collect();
            let mut point = PointSums::default();
            point.add(&measured, &[0.5; 8], 1.0);
            points.push(point);
        }
        let found = net_error(&points);
        assert!((found - 0.5).abs() < 0.01, "{found}");
        assert!(standard_error(&points) < 0.05);
        let exact: Vec<PointSums> =
            points.iter().map(|point| PointSums { error: 0.5 * point.of_mean, ..*point }).collect();
        assert_eq!(net_error(&exact), 0.0);
        // An answer that knows each sample, but for an error that all of them share, has that error and no scatter.
        let mut known = PointSums::default();
        known.add(&[1.0, 2.0, 4.0, 5.0], &[1.3, 2.3, 4.3, 5.3], 1.0);
        assert!((net_error(&[known]) - 0.3 / (10.0f64 / 3.0).sqrt()).abs() < 1e-12);
    }
}
