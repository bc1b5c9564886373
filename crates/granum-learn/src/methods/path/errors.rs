//! How large the errors of networks with a state are along a path, and by what factor their deviations must be multiplied so that intervals hold.
//!
//! Each training run is predicted by the network that was not trained on it. With its errors `e`, the variance `b` between all networks, and the
//! length `s` of the path of strain since the sample, the variance of a new run is
//!
//! ```text
//! v(s, d) = b + f(s) g(d)
//! ```
//!
//! with the largest distance d from the start so far ([`super::growth`]).
//! Half widths of intervals are `s(u) sqrt(v)` times a factor: the one with which the share of the states of training runs that hold is the level (conformal calibration by whole runs).
//! `s(u)` is the size of errors for samples at the place `u` among those of the training runs, a function as for curves ([`ErrorSize`]), fitted to the root mean square
//! of `e / sqrt(v)` of each training run, times the size of what is left in the runs whose samples are most alike ([`neighbours`]): dense and loose samples do not scatter
//! alike. What is said of a training run is said without it.

use serde::{Deserialize, Serialize};

use super::growth::{Growth, PathPlaces};
use super::sample_places::SamplePlaces;
use crate::methods::curve_process::{Calibration, ErrorSize};
use crate::methods::neighbours;
use crate::onnx::{self, OnnxEstimate, OnnxGraph, Value};
use crate::surrogate::prediction::{Cause, Estimate};

/// Fewest runs for intervals.
const FEWEST_RUNS: usize = 3;

/// The errors of left-out runs along paths, and their calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathErrors {
    /// The length of the longest path.
    longest: f64,
    /// The largest ratio of the length to the farthest distance; zero in files of earlier versions, which say nothing of it.
    #[serde(default)]
    largest_ratio: f64,
    /// Absent in files of earlier versions, as the size of errors is.
    #[serde(default)]
    samples: SamplePlaces,
    /// The places of the training runs among themselves; empty in files of earlier versions.
    #[serde(default)]
    places: Vec<Vec<f64>>,
    outputs: Vec<OutputErrors>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputErrors {
    growth: Growth,
    /// How large errors are for one sample and for another.
    #[serde(default)]
    size: ErrorSize,
    /// For each training run the mean square of its errors over their deviations and this size; empty in files of earlier versions.
    #[serde(default)]
    squares: Vec<f64>,
    calibration: Calibration,
}

/// Divides the errors of each run by its size.
fn divide(errors: &mut [Vec<f64>], sizes: &[f64]) {
    for (errors, size) in errors.iter_mut().zip(sizes) {
        errors.iter_mut().for_each(|error| *error /= size);
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
    /// From the outputs of each network in row-major order, what was measured, and by what the errors of each are divided ([`super::channels::Channels::units`]), where run `r` was left out by network `r % networks`. `None` from fewer
    /// than three runs, or if nothing is finite.
    pub fn new(
        networks: &[Vec<f64>],
        targets: &[f64],
        units: &[f64],
        places: &PathPlaces,
    ) -> Option<PathErrors> {
        let (rows, runs, run_of_row) = (places.length.len(), places.samples.len(), &places.run);
        let outputs = units.len() / rows.max(1);
        if runs < FEWEST_RUNS || networks.len() < 2 {
            return None;
        }
        let samples = SamplePlaces::new(&places.samples);
        let place_of_run: Vec<Vec<f64>> = places.samples.iter().map(|sample| samples.place(sample)).collect();
        let weights: Vec<Vec<f64>> =
            (0..runs).map(|run| neighbours::weights(&place_of_run, &place_of_run[run], Some(run))).collect();
        let of_output = |output: usize| {
            let error = |row: usize| {
                let place = row * outputs + output;
                (networks[run_of_row[row] % networks.len()][place] - targets[place]) / units[place]
            };
            let between = |row: usize| {
                let place = row * outputs + output;
                mean_and_variance(networks, place).1 / (units[place] * units[place])
            };
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
            divide(&mut scaled, &fitted.left_out);
            let squares: Vec<f64> = scaled.iter().map(|errors| root_mean_square(errors).powi(2)).collect();
            let alike: Vec<f64> = weights.iter().map(|weights| neighbours::size(weights, &squares)).collect();
            divide(&mut scaled, &alike);
            let most = scaled.iter().map(Vec::len).max().unwrap_or(0);
            let calibration = Calibration::new(&scaled, &vec![1.0; most]).with_six_digits();
            OutputErrors { growth, size: fitted.size, squares, calibration }
        };
        let longest = places.length.iter().copied().fold(0.0, f64::max);
        let outputs_errors = (0..outputs).map(of_output).collect();
        let largest_ratio = (0..rows).filter_map(|row| places.ratio(row)).fold(0.0, f64::max);
        let found =
            PathErrors { longest, largest_ratio, outputs: outputs_errors, samples, places: place_of_run };
        found.is_whole(outputs).then_some(found)
    }

    /// The length of the longest training path.
    pub fn longest(&self) -> f64 {
        self.longest
    }

    /// The largest ratio of the length of a training path to its farthest distance from the start so far; zero if it is not known.
    pub fn largest_ratio(&self) -> f64 {
        self.largest_ratio
    }

    /// The distance of training paths that turn as often as others do.
    fn farthest(&self, places: &PathPlaces, row: usize) -> f64 {
        let least = if self.largest_ratio > 0.0 { places.length[row] / self.largest_ratio } else { 0.0 };
        places.farthest[row].max(least)
    }

    /// The factors of intervals of a level, for each output.
    pub fn factors(&self, level: f64) -> Vec<f64> {
        self.outputs.iter().map(|own| own.calibration.interval(level)).collect()
    }

    /// For each sample by how much the errors of each output are larger than those of all samples.
    pub fn sizes(&self, samples: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of_sample = |sample: &Vec<f64>| {
            let place = self.samples.place(sample);
            let weights = neighbours::weights(&self.places, &place, None);
            let size = |own: &OutputErrors| own.size.at(&place) * neighbours::size(&weights, &own.squares);
            self.outputs.iter().map(size).collect()
        };
        samples.iter().map(of_sample).collect()
    }

    /// The estimate of an output in a row; the size is that for its sample, the unit that of its errors, and the factor that of its intervals.
    pub fn estimate(
        &self,
        networks: &[Vec<f64>],
        (row, output): (usize, usize),
        places: &PathPlaces,
        [size, unit, factor]: [f64; 3],
    ) -> Estimate {
        let (mean, between) = mean_and_variance(networks, row * self.outputs.len() + output);
        let growth = &self.outputs[output].growth;
        let runs = growth.variance(places.length[row], self.farthest(places, row)).sqrt();
        let causes = vec![(Cause::Parameters, size * between.sqrt()), (Cause::Runs, size * unit * runs)];
        Estimate::new(mean).by(causes, factor)
    }

    /// The result of [`PathErrors::sizes`] in a graph for samples, a row each: a column for each output. `None` if it is the same for all of them.
    pub fn onnx_sizes(&self, graph: &mut OnnxGraph, samples: &Value) -> Option<Value> {
        if self.samples.values() == 0 || self.places.is_empty() {
            return None;
        }
        let places = self.samples.onnx(graph, samples);
        let weights = neighbours::onnx_weights(graph, &self.places, &places);
        let mut sizes = Vec::with_capacity(self.outputs.len());
        for own in &self.outputs {
            let alike = neighbours::onnx_size(graph, &weights, &own.squares);
            sizes.push(match own.size.onnx(graph, &places) {
                Some(size) => graph.apply("Mul", &[&size, &alike]),
                None => alike,
            });
        }
        Some(graph.beside(&sizes.iter().collect::<Vec<_>>()))
    }

    /// The result of [`PathErrors::estimate`] in a graph, from the answers of the networks, columns of lengths and farthest places, and the column of the size.
    pub fn onnx_estimate(
        &self,
        graph: &mut OnnxGraph,
        answers: &[Value],
        output: usize,
        [length, farthest]: [&Value; 2],
        (size, unit, factor): (&Value, Option<&Value>, f64),
    ) -> OnnxEstimate {
        let [mean, between] = onnx::mean_and_variance(graph, answers, output);
        let farthest = match self.largest_ratio > 0.0 {
            true => {
                let per_ratio = graph.number(1.0 / self.largest_ratio);
                let least = graph.apply("Mul", &[length, &per_ratio]);
                graph.apply("Max", &[farthest, &least])
            }
            false => farthest.clone(),
        };
        let mut of_runs = self.outputs[output].growth.onnx(graph, length, &farthest);
        if let Some(unit) = unit {
            let square = graph.apply("Mul", &[unit, unit]);
            of_runs = graph.apply("Mul", &[&of_runs, &square]);
        }
        let variance = graph.apply("Add", &[&between, &of_runs]);
        let deviation = graph.apply("Sqrt", &[&variance]);
        let deviation = graph.apply("Mul", &[&deviation, size]);
        OnnxEstimate { mean, spread: onnx::spread(graph, Some(deviation), factor) }
    }

    /// True if they can be those of so many outputs.
    pub fn is_whole(&self, outputs: usize) -> bool {
        self.longest >= 0.0
            && self.longest.is_finite()
            && self.largest_ratio >= 0.0
            && self.largest_ratio.is_finite()
            && self.outputs.len() == outputs
            && self.samples.is_sound()
            && self.places.iter().all(|place| place.len() == self.samples.values())
            && self.places.iter().flatten().all(|share| (0.0..=1.0).contains(share))
            && self.outputs.iter().all(|own| {
                own.growth.is_sound()
                    && own.squares.len() == self.places.len()
                    && own.squares.iter().all(|square| *square >= 0.0 && square.is_finite())
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
        PathErrors::new(&[network(0), network(1)], &vec![1.0; rows], &vec![1.0; rows], &places).unwrap()
    }

    /// The half width of an interval where the path has a length and a farthest place, and two networks say something.
    fn half(errors: &PathErrors, [length, farthest]: [f64; 2], networks: [f64; 2]) -> f64 {
        half_of(errors, [length, farthest], 0.5, networks)
    }

    /// The same for a sample of its own.
    fn half_of(errors: &PathErrors, [length, farthest]: [f64; 2], sample: f64, networks: [f64; 2]) -> f64 {
        let (length, farthest, samples) = (vec![length], vec![farthest], vec![vec![sample]]);
        let places = PathPlaces { length, farthest, run: vec![0], samples };
        let by = [errors.sizes(&places.samples)[0][0], 1.0, errors.factors(0.9)[0]];
        let estimate = errors.estimate(&networks.map(|value| vec![value]), (0, 0), &places, by);
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
        assert!((half(4.0, [1.0, 1.0]) / half(1.0, [1.0, 1.0]) - 4.0).abs() < 1e-9);
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

    /// Errors of training paths grow with the distance alone; one that turns more often is taken as one that leads farther.
    #[test]
    fn errors_grow_where_a_path_turns_more_often_than_any_training_path() {
        let errors = errors(101, |_, state| state as f64, |_, state| 0.01 * state as f64);
        assert!((errors.largest_ratio() - 5.0).abs() < 1e-9);
        let half = |place: [f64; 2]| half(&errors, place, [1.0; 2]);
        assert_eq!(half([0.5, 0.02]), half([0.5, 0.1]));
        assert!(half([0.5, 0.1]) > 2.0 * half([0.1, 0.02]));
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
        let ratio = half(0.95) / half(0.05);
        assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
    }

    /// Files that were written before intervals knew the sample are read, and say the same for each.
    #[test]
    fn errors_of_earlier_files_are_alike_for_all_samples() {
        let errors = errors(200, |run, _| libm::exp(sample(run)), |_, _| 1.0);
        let mut kept = serde_json::to_value(&errors).unwrap();
        kept.as_object_mut().unwrap().remove("samples").unwrap();
        kept.as_object_mut().unwrap().remove("places").unwrap();
        kept.as_object_mut().unwrap().remove("largest_ratio").unwrap();
        kept["outputs"][0].as_object_mut().unwrap().remove("size").unwrap();
        kept["outputs"][0].as_object_mut().unwrap().remove("squares").unwrap();
        let earlier: PathErrors = serde_json::from_value(kept).unwrap();
        assert!(earlier.is_whole(1));
        assert_eq!(earlier.largest_ratio(), 0.0);
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
        assert!(PathErrors::new(&[network.clone(), network], &[0.0; 4], &[1.0; 4], &places).is_none());
    }
}
