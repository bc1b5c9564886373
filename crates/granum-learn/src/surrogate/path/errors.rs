//! How large the errors of networks with a state are along a path, and by what factor their deviations must be multiplied so that intervals hold.
//!
//! Each training run is predicted by the network that was not trained on it. With its errors `e`, the variance `b` between all networks, and the
//! length `s` of the path of strain since the sample, the variance of a new run is
//!
//! ```text
//! v(s) = b + r(s),    r(s) = mean of e^2 - b over the training states near s, at least 0
//! ```
//!
//! in ten parts of the length, linear between their middles. Errors grow along a path, since each state follows from the one before. Beyond the longest
//! training path `r` grows in proportion to the length, as the square of a random walk does. Half widths of intervals are `sqrt(v)` times a factor:
//! the one with which the share of the states of training runs that hold is the level (conformal calibration by whole runs).

use serde::{Deserialize, Serialize};

use crate::curve::{increases, interpolated};
use crate::surrogate::curve_process::Calibration;
use crate::surrogate::prediction::{Cause, Estimate};

/// Number of parts of the length of paths.
const PARTS: usize = 10;
/// Fewest runs for intervals.
const FEWEST_RUNS: usize = 3;
/// Share of the mean variance of an output below which variances are not told apart.
const LEAST: f64 = 1e-6;

/// The errors of left-out runs along paths, and their calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathErrors {
    /// Middles of the parts of the length.
    at: Vec<f64>,
    /// The length of the longest path.
    longest: f64,
    outputs: Vec<OutputErrors>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputErrors {
    /// Variance beyond that between the networks in each part.
    variances: Vec<f64>,
    calibration: Calibration,
}

/// Mean of the networks' values at a place, and the variance between them.
fn mean_and_variance(networks: &[Vec<f64>], place: usize) -> (f64, f64) {
    let count = networks.len() as f64;
    let mean = networks.iter().map(|values| values[place]).sum::<f64>() / count;
    let squares: f64 = networks.iter().map(|values| (values[place] - mean) * (values[place] - mean)).sum();
    (mean, squares / (count - 1.0).max(1.0))
}

impl PathErrors {
    /// From the outputs of each network in row-major order and what was measured, where run `r` was left out by network `r % networks`; `path` is the
    /// length at each row. `None` from fewer than three runs, or if nothing is finite.
    pub fn new(
        networks: &[Vec<f64>],
        targets: &[f64],
        outputs: usize,
        (lengths, path): (&[usize], &[f64]),
    ) -> Option<PathErrors> {
        if lengths.len() < FEWEST_RUNS || networks.len() < 2 {
            return None;
        }
        let mut run_of_row = Vec::with_capacity(path.len());
        lengths.iter().enumerate().for_each(|(run, length)| run_of_row.extend(vec![run; *length]));
        let mut rows: Vec<usize> = (0..path.len()).collect();
        rows.sort_by(|a, b| path[*a].total_cmp(&path[*b]));
        let parts: Vec<&[usize]> = rows.chunks(rows.len().div_ceil(PARTS).max(1)).collect();
        let middle = |part: &&[usize]| part.iter().map(|row| path[*row]).sum::<f64>() / part.len() as f64;
        let middles: Vec<f64> = parts.iter().map(middle).collect();
        // Paths of no length have one part.
        let is_kept = |k: &usize| *k == 0 || middles[*k] > middles[*k - 1];
        let kept: Vec<usize> = (0..parts.len()).filter(is_kept).collect();
        let at: Vec<f64> = kept.iter().map(|k| middles[*k]).collect();
        let longest = path.iter().copied().fold(0.0, f64::max);
        let mut found = PathErrors { at, longest, outputs: Vec::with_capacity(outputs) };
        for output in 0..outputs {
            let error = |row: usize| {
                let place = row * outputs + output;
                networks[run_of_row[row] % networks.len()][place] - targets[place]
            };
            let between = |row: usize| mean_and_variance(networks, row * outputs + output).1;
            let mean = (0..path.len()).map(|row| error(row) * error(row)).sum::<f64>() / path.len() as f64;
            let least = LEAST * mean;
            let of_part = |k: &usize| {
                let excess = parts[*k].iter().map(|row| error(*row) * error(*row) - between(*row));
                (excess.sum::<f64>() / parts[*k].len() as f64).max(least)
            };
            let variances: Vec<f64> = kept.iter().map(of_part).collect();
            found.outputs.push(OutputErrors { variances, calibration: Calibration::default() });
            let mut scaled: Vec<Vec<f64>> = vec![Vec::new(); lengths.len()];
            for row in 0..path.len() {
                let deviation = (between(row) + found.variance(output, path[row])).sqrt();
                let over = if deviation > 0.0 { error(row) / deviation } else { 0.0 };
                scaled[run_of_row[row]].push(over);
            }
            let most = lengths.iter().copied().max().unwrap_or(0);
            found.outputs[output].calibration = Calibration::new(&scaled, &vec![1.0; most]).with_six_digits();
        }
        found.is_whole(outputs).then_some(found)
    }

    /// The length of the longest training path.
    pub fn longest(&self) -> f64 {
        self.longest
    }

    /// The variance of a new run beyond that between the networks, at a length of the path.
    fn variance(&self, output: usize, path: f64) -> f64 {
        let within = interpolated(path.min(self.longest), &self.at, &self.outputs[output].variances);
        if path > self.longest && self.longest > 0.0 { within * path / self.longest } else { within }
    }

    /// The factors of intervals of a level, for each output.
    pub fn factors(&self, level: f64) -> Vec<f64> {
        self.outputs.iter().map(|own| own.calibration.interval(level)).collect()
    }

    /// The estimate of an output in a row; `factor` is that of its intervals.
    pub fn estimate(
        &self,
        networks: &[Vec<f64>],
        (row, output): (usize, usize),
        path: f64,
        factor: f64,
    ) -> Estimate {
        let (mean, between) = mean_and_variance(networks, row * self.outputs.len() + output);
        let runs = self.variance(output, path).sqrt();
        Estimate::new(mean).by(vec![(Cause::Parameters, between.sqrt()), (Cause::Runs, runs)], factor)
    }

    /// True if they can be those of so many outputs.
    pub fn is_whole(&self, outputs: usize) -> bool {
        let positive = |value: &f64| *value >= 0.0 && value.is_finite();
        let of_output = |own: &OutputErrors| {
            own.variances.len() == self.at.len()
                && own.variances.iter().all(positive)
                && own.calibration.is_sound()
        };
        !self.at.is_empty()
            && increases(&self.at)
            && self.at.iter().chain([&self.longest]).all(positive)
            && self.outputs.len() == outputs
            && self.outputs.iter().all(of_output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs whose errors grow with the path, uniform between runs; the networks are the same but for the run that they were not trained on.
    fn errors(runs: usize) -> PathErrors {
        let (lengths, rows) = (vec![21; runs], 21 * runs);
        let path: Vec<f64> = (0..rows).map(|row| 0.05 * (row % 21) as f64).collect();
        let targets: Vec<f64> = vec![1.0; rows];
        let error = |row: usize| {
            let run = row / 21;
            (2.0 * run as f64 / (runs - 1) as f64 - 1.0) * (0.1 + path[row])
        };
        let network = |k: usize| {
            let value = |row: usize| 1.0 + if (row / 21) % 2 == k { error(row) } else { 0.0 };
            (0..rows).map(value).collect()
        };
        PathErrors::new(&[network(0), network(1)], &targets, 1, (&lengths, &path)).unwrap()
    }

    #[test]
    fn intervals_grow_along_the_path_and_hold_their_level() {
        let errors = errors(101);
        let factor = errors.factors(0.9)[0];
        let half = |path: f64, networks: [f64; 2]| {
            let estimate = errors.estimate(&networks.map(|value| vec![value]), (0, 0), path, factor);
            let interval = estimate.interval.unwrap();
            assert!(
                (0.5 * (interval.upper + interval.lower) - 0.5 * (networks[0] + networks[1])).abs() < 1e-12
            );
            0.5 * (interval.upper - interval.lower)
        };
        // Nine of ten runs have errors below 0.9 (0.1 + s); in such a run one network has this error and the other none.
        let ratio = half(0.9, [1.0, 1.0]) / half(0.3, [1.0, 1.0]);
        assert!((ratio - 2.5).abs() < 0.15, "{ratio}");
        let of_training = |s: f64| half(s, [1.0, 1.0 + 0.9 * (0.1 + s)]);
        assert!((of_training(0.5) / (0.9 * 0.6) - 1.0).abs() < 0.1, "{}", of_training(0.5));
        // Where networks differ it is wider, and beyond the longest path it grows.
        assert!(half(0.5, [0.0, 2.0]) > 1.4);
        assert!((half(4.0, [1.0, 1.0]) / half(1.0, [1.0, 1.0]) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn two_runs_say_nothing_of_their_scatter() {
        let network = vec![0.0; 4];
        assert!(
            PathErrors::new(&[network.clone(), network], &[0.0; 4], 1, (&[2, 2], &[0.0, 1.0, 0.0, 1.0]))
                .is_none()
        );
    }
}
