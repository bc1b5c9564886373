//! How the errors of networks with a state grow along a path.
//!
//! The squared error `e^2` of a network beyond the variance `b` between the networks is, at the length `s` of the path of strain since the sample,
//!
//! ```text
//! v(s, d) - b = f(s) g(d)
//! ```
//!
//! with the largest distance d from the start so far: errors of independent increments add up along a path, and systematic ones grow with how far it leads,
//! which a straight path does more than one that turns. `f` and `g` have a value in each of ten parts, linear between their middles. They are found in turns: each value
//! of `f` is the sum of `e^2 - b` over that of `g` for the training states of its part, at least 0, and so for `g` (a multiplicative model of variances, by iterative
//! proportional fitting). Beyond the largest `s` of training `f` grows as its square: what is not known of a path is the same in each of its increments, and adds up. `g` is that of the
//! farthest training states. A path that turns more often than any training path is taken as one that leads farther: `d` is at least `s / r` with the largest `s / d` of training, `r`.

use serde::{Deserialize, Serialize};

use crate::curve::{increases, interpolated};
use crate::onnx::{self, OnnxGraph, Value};

/// Number of parts of the length of paths.
const PARTS: usize = 10;
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

/// Where a path is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PathPlace {
    /// Its length.
    pub length: f64,
    /// The largest distance from its start so far.
    pub farthest: f64,
    /// The sum of all increments.
    sum: Vec<f64>,
}

impl PathPlace {
    /// Goes on by an increment.
    pub fn advance(&mut self, increment: &[f64]) {
        self.sum.resize(increment.len(), 0.0);
        self.sum.iter_mut().zip(increment).for_each(|(sum, c)| *sum += c);
        self.length += norm(increment);
        self.farthest = f64::max(self.farthest, norm(&self.sum));
    }

    /// Length, largest distance, and the components of the sum of all increments.
    pub fn numbers(&self) -> Vec<f64> {
        [self.length, self.farthest].into_iter().chain(self.sum.iter().copied()).collect()
    }

    /// From the result of [`PathPlace::numbers`] for increments of so many components; `None` for other numbers.
    pub fn from_numbers(numbers: &[f64], components: usize) -> Option<PathPlace> {
        let (&[length, farthest], sum) = numbers.split_first_chunk::<2>()?;
        let is_whole = sum.len() == components && length >= 0.0 && farthest >= 0.0;
        is_whole.then(|| PathPlace { length, farthest, sum: sum.to_vec() })
    }
}

pub(super) fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

impl PathPlaces {
    /// The length at a row over the farthest distance, if the path has left its start.
    pub fn ratio(&self, row: usize) -> Option<f64> {
        (self.farthest[row] > 0.0).then(|| self.length[row] / self.farthest[row])
    }
}

/// The variance beyond that between the networks: a factor by the length of a path, and one by its farthest place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Growth {
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

    /// The value at a place; beyond the ends it is that at the end.
    fn value(&self, place: f64) -> f64 {
        interpolated(place, &self.at, &self.values)
    }

    /// How many times the largest value a place is, and one for smaller ones.
    fn times_the_most(&self, place: f64) -> f64 {
        if self.most > 0.0 { (place / self.most).max(1.0) } else { 1.0 }
    }

    /// The value at the places in a column of a graph.
    fn onnx(&self, graph: &mut OnnxGraph, places: &Value) -> Value {
        onnx::interpolated(graph, places, &self.at, &self.values)
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
    pub fn new(places: &PathPlaces, excess: &[f64], mean: f64) -> Growth {
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

    /// The variance where the path has a length and a farthest place.
    pub fn variance(&self, length: f64, farthest: f64) -> f64 {
        let times = self.by_length.times_the_most(length);
        self.by_length.value(length) * self.by_distance.value(farthest) * times * times
    }

    /// The variance in a graph, for columns of lengths and farthest places.
    pub fn onnx(&self, graph: &mut OnnxGraph, length: &Value, farthest: &Value) -> Value {
        let (by_length, by_distance) =
            (self.by_length.onnx(graph, length), self.by_distance.onnx(graph, farthest));
        let variance = graph.apply("Mul", &[&by_length, &by_distance]);
        if self.by_length.most <= 0.0 {
            return variance;
        }
        let [per_most, one] = [1.0 / self.by_length.most, 1.0].map(|value| graph.number(value));
        let times = graph.apply("Mul", &[length, &per_most]);
        let times = graph.apply("Max", &[&times, &one]);
        let square = graph.apply("Mul", &[&times, &times]);
        graph.apply("Mul", &[&variance, &square])
    }

    /// True if the numbers are those of variances.
    pub fn is_sound(&self) -> bool {
        self.by_length.is_sound() && self.by_distance.is_sound()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paths of 100 rows, each of which turns more often than the one before.
    fn places() -> PathPlaces {
        let rows: Vec<(f64, f64)> = (0..40)
            .flat_map(|run| {
                let turns = 1.0 + 0.5 * f64::from(run);
                (1..=100).map(move |row| (0.01 * f64::from(row), 0.01 * f64::from(row) / turns))
            })
            .collect();
        PathPlaces {
            length: rows.iter().map(|row| row.0).collect(),
            farthest: rows.iter().map(|row| row.1).collect(),
            ..PathPlaces::default()
        }
    }

    #[test]
    fn both_factors_are_found() {
        let places = places();
        let excess: Vec<f64> =
            places.length.iter().zip(&places.farthest).map(|(s, d)| (1.0 + s) * (0.2 + d)).collect();
        let growth = Growth::new(&places, &excess, 1.0);
        assert!(growth.is_sound());
        for [s, d] in [[0.3, 0.05], [0.5, 0.2], [0.8, 0.1], [0.8, 0.4]] {
            let ratio = growth.variance(s, d) / ((1.0 + s) * (0.2 + d));
            assert!((ratio - 1.0).abs() < 0.05, "{s} {d}: {ratio}");
        }
    }

    #[test]
    fn beyond_the_longest_path_deviations_grow_in_proportion_to_the_length() {
        let places = places();
        let growth = Growth::new(&places, &vec![2.0; places.length.len()], 2.0);
        assert!((growth.variance(1.0, 0.3) - 2.0).abs() < 1e-9);
        assert!((growth.variance(3.0, 0.3) - 18.0).abs() < 1e-9);
        assert!((growth.variance(3.0, 30.0) - 18.0).abs() < 1e-9);
    }

    #[test]
    fn the_ratio_tells_how_often_a_path_turns() {
        let path = PathPlaces {
            length: vec![0.0, 0.2, 0.4],
            farthest: vec![0.0, 0.2, 0.2],
            ..PathPlaces::default()
        };
        assert_eq!([0, 1, 2].map(|row| path.ratio(row)), [None, Some(1.0), Some(2.0)]);
    }
}
