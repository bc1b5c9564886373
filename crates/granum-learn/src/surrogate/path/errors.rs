//! How large the errors of networks with a state are along a path, and by what factor their deviations must be multiplied so that intervals hold.
//!
//! Each training run is predicted by the network that was not trained on it. With its errors `e`, the variance `b` between all networks, and the
//! length `s` of the path of strain since the sample, the variance of a new run is
//!
//! ```text
//! v(s, d) = b + f(s) g(d)
//! ```
//!
//! with the largest distance d from the start so far: errors of independent increments add up along a path, and systematic ones grow with how far it leads,
//! which a straight path does more than one that turns. `f` and `g` have a value in each of ten parts, linear between their middles. They are found in turns: each value
//! of `f` is the sum of `e^2 - b` over that of `g` for the training states of its part, at least 0, and so for `g` (a multiplicative model of variances, by iterative
//! proportional fitting). Beyond the largest `s` of training `f` grows in proportion to it, as the square of a random walk does, and `g` as the square of `d`. Half widths of
//! intervals are `s(u) sqrt(v)` times a factor: the one with which the share of the states of training runs that hold is the level (conformal calibration by whole runs).
//! `s(u)` is the size of errors for samples at the place `u` among those of the training runs, a function as for curves ([`ErrorSize`]), fitted to the root mean square
//! of `e / sqrt(v)` of each training run: dense and loose samples do not scatter alike.

use serde::{Deserialize, Serialize};

use super::sample_places::SamplePlaces;
use crate::curve::{increases, interpolated};
use crate::surrogate::curve_process::{Calibration, ErrorSize};
use crate::surrogate::prediction::{Cause, Estimate};

/// Number of parts of the length of paths.
const PARTS: usize = 10;
/// Fewest runs for intervals.
const FEWEST_RUNS: usize = 3;
/// Share of the mean variance of an output below which variances are not told apart.
const LEAST: f64 = 1e-6;
/// How often both factors are found in turns.
const TURNS: usize = 20;

/// How far the path of a run is at each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PathPlaces {
    /// Its length.
    pub length: Vec<f64>,
    /// The largest distance from its start so far.
    pub farthest: Vec<f64>,
    /// The run of each row.
    pub run: Vec<usize>,
    /// For each run the values that describe its sample.
    pub samples: Vec<Vec<f64>>,
}

/// The errors of left-out runs along paths, and their calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathErrors {
    /// The length of the longest path.
    longest: f64,
    /// Absent in files of earlier versions, as the size of errors is.
    #[serde(default)]
    samples: SamplePlaces,
    outputs: Vec<OutputErrors>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputErrors {
    growth: Growth,
    /// How large errors are for one sample and for another.
    #[serde(default)]
    size: ErrorSize,
    calibration: Calibration,
}

/// The variance beyond that between the networks: a factor by the length of a path, and one by its farthest place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Growth {
    by_length: Curve,
    by_distance: Curve,
}

/// A factor in parts of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Curve {
    /// Middles of the parts, and the value in each.
    at: Vec<f64>,
    values: Vec<f64>,
    /// The largest value of the quantity.
    most: f64,
}

impl Curve {
    /// One everywhere, with the part of each row.
    fn new(places: &[f64]) -> (Curve, Vec<usize>) {
        let mut rows: Vec<usize> = (0..places.len()).collect();
        rows.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
        let (mut at, mut part_of_row) = (Vec::<f64>::new(), vec![0; places.len()]);
        for part in rows.chunks(rows.len().div_ceil(PARTS).max(1)) {
            let middle = part.iter().map(|row| places[*row]).sum::<f64>() / part.len() as f64;
            // Paths of no length have one part.
            if at.last().is_none_or(|last| middle > *last) {
                at.push(middle);
            }
            part.iter().for_each(|row| part_of_row[*row] = at.len() - 1);
        }
        let values = vec![1.0; at.len()];
        (Curve { at, values, most: places.iter().copied().fold(0.0, f64::max) }, part_of_row)
    }

    /// The value at a place, and beyond the largest one that times the share by which it is larger, to a power.
    fn value(&self, place: f64, power: i32) -> f64 {
        let within = interpolated(place.min(self.most), &self.at, &self.values);
        if place > self.most && self.most > 0.0 { within * (place / self.most).powi(power) } else { within }
    }

    /// Sets each value to the sum of the excess of the rows of its part over that of the other factor.
    fn set(&mut self, part_of_row: &[usize], excess: &[f64], other: impl Fn(usize) -> f64, least: f64) {
        let mut sums = vec![(0.0, 0.0); self.at.len()];
        for (row, part) in part_of_row.iter().enumerate() {
            sums[*part].0 += excess[row];
            sums[*part].1 += other(row);
        }
        let ratio =
            |(excess, other): (f64, f64)| if other > 0.0 { (excess / other).max(least) } else { least };
        self.values = sums.into_iter().map(ratio).collect();
    }

    fn is_sound(&self) -> bool {
        let positive = |value: &f64| *value >= 0.0 && value.is_finite();
        !self.at.is_empty()
            && increases(&self.at)
            && self.values.len() == self.at.len()
            && self.at.iter().chain(&self.values).chain([&self.most]).all(positive)
    }
}

impl Growth {
    /// From the rows, for each of which it is told how far the path is, and how much larger the squared error of the network that did not learn from its run is than the
    /// variance between networks; `mean` is that of the squared errors.
    fn new(places: &PathPlaces, excess: &[f64], mean: f64) -> Growth {
        let (mut by_length, of_length) = Curve::new(&places.length);
        let (mut by_distance, of_distance) = Curve::new(&places.farthest);
        for _ in 0..TURNS {
            let distance = by_distance.values.clone();
            by_length.set(&of_length, excess, |row| distance[of_distance[row]], LEAST * mean);
            let length = by_length.values.clone();
            by_distance.set(&of_distance, excess, |row| length[of_length[row]], LEAST);
        }
        Growth { by_length, by_distance }
    }

    fn variance(&self, length: f64, farthest: f64) -> f64 {
        self.by_length.value(length, 1) * self.by_distance.value(farthest, 2)
    }

    fn is_sound(&self) -> bool {
        self.by_length.is_sound() && self.by_distance.is_sound()
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Mean of the networks' values at a place, and the variance between them.
fn mean_and_variance(networks: &[Vec<f64>], place: usize) -> (f64, f64) {
    let count = networks.len() as f64;
    let mean = networks.iter().map(|values| values[place]).sum::<f64>() / count;
    let squares: f64 = networks.iter().map(|values| (values[place] - mean) * (values[place] - mean)).sum();
    (mean, squares / (count - 1.0).max(1.0))
}

impl PathErrors {
    /// From the outputs of each network in row-major order and what was measured, where run `r` was left out by network `r % networks`. `None` from fewer
    /// than three runs, or if nothing is finite.
    pub fn new(
        networks: &[Vec<f64>],
        targets: &[f64],
        outputs: usize,
        places: &PathPlaces,
    ) -> Option<PathErrors> {
        let (rows, runs, run_of_row) = (places.length.len(), places.samples.len(), &places.run);
        if runs < FEWEST_RUNS || networks.len() < 2 {
            return None;
        }
        let samples = SamplePlaces::new(&places.samples);
        let place_of_run: Vec<Vec<f64>> = places.samples.iter().map(|sample| samples.place(sample)).collect();
        let of_output = |output: usize| {
            let error = |row: usize| {
                let place = row * outputs + output;
                networks[run_of_row[row] % networks.len()][place] - targets[place]
            };
            let between = |row: usize| mean_and_variance(networks, row * outputs + output).1;
            let mean = (0..rows).map(|row| error(row) * error(row)).sum::<f64>() / rows as f64;
            let excess: Vec<f64> = (0..rows).map(|row| error(row) * error(row) - between(row)).collect();
            let growth = Growth::new(places, &excess, mean);
            let mut scaled: Vec<Vec<f64>> = vec![Vec::new(); runs];
            for row in 0..rows {
                let variance = growth.variance(places.length[row], places.farthest[row]);
                let deviation = (between(row) + variance).sqrt();
                scaled[run_of_row[row]].push(if deviation > 0.0 { error(row) / deviation } else { 0.0 });
            }
            let fitted = ErrorSize::fit(
                &place_of_run,
                &scaled.iter().map(|errors| root_mean_square(errors)).collect::<Vec<_>>(),
            );
            for (errors, size) in scaled.iter_mut().zip(&fitted.left_out) {
                errors.iter_mut().for_each(|error| *error /= size);
            }
            let most = scaled.iter().map(Vec::len).max().unwrap_or(0);
            let calibration = Calibration::new(&scaled, &vec![1.0; most]).with_six_digits();
            OutputErrors { growth, size: fitted.size, calibration }
        };
        let longest = places.length.iter().copied().fold(0.0, f64::max);
        let found = PathErrors { longest, outputs: (0..outputs).map(of_output).collect(), samples };
        found.is_whole(outputs).then_some(found)
    }

    /// The length of the longest training path.
    pub fn longest(&self) -> f64 {
        self.longest
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
        places: &PathPlaces,
        factor: f64,
    ) -> Estimate {
        let (mean, between) = mean_and_variance(networks, row * self.outputs.len() + output);
        let OutputErrors { growth, size, .. } = &self.outputs[output];
        let size = size.at(&self.samples.place(&places.samples[places.run[row]]));
        let runs = growth.variance(places.length[row], places.farthest[row]).sqrt();
        let causes = vec![(Cause::Parameters, size * between.sqrt()), (Cause::Runs, size * runs)];
        Estimate::new(mean).by(causes, factor)
    }

    /// True if they can be those of so many outputs.
    pub fn is_whole(&self, outputs: usize) -> bool {
        self.longest >= 0.0
            && self.longest.is_finite()
            && self.outputs.len() == outputs
            && self.samples.is_sound()
            && self.outputs.iter().all(|own| {
                own.growth.is_sound()
                    && own.size.is_sound(self.samples.values())
                    && own.calibration.is_sound()
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATES: usize = 21;

    /// Samples in an order of their own.
    fn sample(run: usize) -> f64 {
        (0.618 * run as f64).fract()
    }

    /// Runs whose errors grow as told, uniform between runs; the networks are the same but for the run that they were not trained on.
    fn errors(
        runs: usize,
        growth: impl Fn(usize, usize) -> f64,
        farthest: impl Fn(usize, usize) -> f64,
    ) -> PathErrors {
        let rows = STATES * runs;
        let at = |place: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
            (0..rows).map(|row| place(row / STATES, row % STATES)).collect()
        };
        let places = PathPlaces {
            length: at(&|_, state| 0.05 * state as f64),
            farthest: at(&farthest),
            run: (0..rows).map(|row| row / STATES).collect(),
            samples: (0..runs).map(|run| vec![sample(run)]).collect(),
        };
        let grown = at(&growth);
        let network = |k: usize| {
            let error = |row: usize| (2.0 * (row / STATES) as f64 / (runs - 1) as f64 - 1.0) * grown[row];
            let value = |row: usize| 1.0 + if (row / STATES) % 2 == k { error(row) } else { 0.0 };
            (0..rows).map(value).collect()
        };
        PathErrors::new(&[network(0), network(1)], &vec![1.0; rows], 1, &places).unwrap()
    }

    /// The half width of an interval where the path has a length and a farthest place, and two networks say something.
    fn half(errors: &PathErrors, [length, farthest]: [f64; 2], networks: [f64; 2]) -> f64 {
        half_of(errors, [length, farthest], 0.5, networks)
    }

    /// The same for a sample of its own.
    fn half_of(errors: &PathErrors, [length, farthest]: [f64; 2], sample: f64, networks: [f64; 2]) -> f64 {
        let (length, farthest, samples) = (vec![length], vec![farthest], vec![vec![sample]]);
        let places = PathPlaces { length, farthest, run: vec![0], samples };
        let factor = errors.factors(0.9)[0];
        let estimate = errors.estimate(&networks.map(|value| vec![value]), (0, 0), &places, factor);
        let interval = estimate.interval.unwrap();
        let middle = 0.5 * (interval.upper + interval.lower);
        assert!((middle - 0.5 * (networks[0] + networks[1])).abs() < 1e-12);
        0.5 * (interval.upper - interval.lower)
    }

    #[test]
    fn intervals_grow_along_the_path_and_hold_their_level() {
        let errors = errors(101, |_, state| 0.1 + 0.05 * state as f64, |_, _| 1.0);
        let half = |length: f64, networks: [f64; 2]| half(&errors, [length, 1.0], networks);
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
    fn errors_grow_with_the_length_and_with_the_distance() {
        // Every third run goes straight on, the others go to and fro; errors are the root of the length times the distance.
        let farthest = |run: usize, state: usize| {
            let length = 0.05 * state as f64;
            if run.is_multiple_of(3) { length } else { length.min(0.3 + 0.1 * (run % 2) as f64) }
        };
        let growth = |run: usize, state: usize| (0.05 * state as f64).sqrt() * (0.1 + farthest(run, state));
        let errors = errors(100, growth, farthest);
        let half = |length: f64, farthest: f64| half(&errors, [length, farthest], [1.0; 2]);
        let by_distance = half(0.9, 0.85) / half(0.9, 0.35);
        // The parts mix distances, so that the effect of one is told somewhat too small.
        assert!(by_distance > 1.4 && by_distance < 0.95 / 0.45, "{by_distance}");
        let by_length = half(0.9, 0.35) / half(0.5, 0.35);
        assert!((by_length - 1.8f64.sqrt()).abs() < 0.2, "{by_length}");
    }

    #[test]
    fn loose_samples_with_larger_errors_have_wider_intervals() {
        let errors = errors(200, |run, _| libm::exp(sample(run)), |_, _| 1.0);
        let half = |sample: f64| half_of(&errors, [0.5, 1.0], sample, [1.0; 2]);
        let ratio = half(0.95) / half(0.05);
        // The errors of single runs scatter, so that less than the whole factor of 2.46 is told.
        assert!(ratio > 1.4 && ratio < 2.6, "{ratio}");
        // Where errors are alike for all samples, intervals are.
        let alike = self::errors(200, |_, _| 1.0, |_, _| 1.0);
        let half = |sample: f64| half_of(&alike, [0.5, 1.0], sample, [1.0; 2]);
        assert_eq!(half(0.95), half(0.05));
    }

    /// Files that were written before intervals knew the sample are read, and say the same for each.
    #[test]
    fn errors_of_earlier_files_are_alike_for_all_samples() {
        let errors = errors(200, |run, _| libm::exp(sample(run)), |_, _| 1.0);
        let mut kept = serde_json::to_value(&errors).unwrap();
        kept.as_object_mut().unwrap().remove("samples").unwrap();
        kept["outputs"][0].as_object_mut().unwrap().remove("size").unwrap();
        let earlier: PathErrors = serde_json::from_value(kept).unwrap();
        assert!(earlier.is_whole(1));
        let half = |sample: f64| half_of(&earlier, [0.5, 1.0], sample, [1.0; 2]);
        assert_eq!(half(0.95), half(0.05));
    }

    #[test]
    fn two_runs_say_nothing_of_their_scatter() {
        let network = vec![0.0; 4];
        let places = PathPlaces {
            length: vec![0.0, 1.0, 0.0, 1.0],
            farthest: vec![0.0, 1.0, 0.0, 1.0],
            run: vec![0, 0, 1, 1],
            samples: vec![vec![0.5], vec![0.7]],
        };
        assert!(PathErrors::new(&[network.clone(), network], &[0.0; 4], 1, &places).is_none());
    }
}
