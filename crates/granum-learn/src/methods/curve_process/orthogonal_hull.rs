//! Which combinations of inputs the training runs have.
//!
//! Ranges of single inputs do not tell whether runs with a high friction had a high resistance to rolling too. In the plane of two inputs the
//! *orthogonal convex hull* of the runs contains the points of which each quadrant, to the upper right, upper left, lower right and lower left, has a
//! run (Ottmann, Soisalon-Soininen and Wood 1984). Each input `x_d` is counted by its place `u_d` among the runs: the share of the runs below it,
//! and beyond their ends the distance from the end over the range. The distance of a point from the hull is
//!
//! ```text
//! D = max over pairs (d, e) and signs (s, t) of  min over runs r of  max(0, s (u_d - u_d^r), t (u_e - u_e^r))
//! ```
//!
//! the side of the largest empty square in a quadrant of which the point is the corner. It is 0 within the hull of every pair. Training runs have
//! distances too, each from the hull of the others; a point is outside if its distance is larger than that of all but 2 % of them.

use crate::onnx::{OnnxGraph, Value};

/// Part of the range of an input by which values differ that are equal but for rounding, at most.
const ROUNDING: f64 = 1e-12;
/// Share of the training runs that would be outside, each judged by the others.
const SHARE_OUTSIDE: f64 = 0.02;

/// The hulls of all pairs of inputs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OrthogonalHull {
    /// For each input its values in the runs, increasing.
    sorted: Vec<Vec<f64>>,
    /// For each input its place in each run.
    places: Vec<Vec<f64>>,
}

/// How far a point is from the hulls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct HullDistance {
    pub distance: f64,
    /// The inputs in whose plane it is; the same one twice if there is a single input.
    pub pair: [usize; 2],
}

impl OrthogonalHull {
    /// From the inputs of runs, of which there is at least one, in row-major order.
    pub fn new(rows: &[f64], inputs: usize) -> OrthogonalHull {
        let column = |input: usize| rows.iter().skip(input).step_by(inputs).copied().collect::<Vec<f64>>();
        let increasing = |input: usize| {
            let mut values = column(input);
            values.sort_by(f64::total_cmp);
            values
        };
        let mut hull = OrthogonalHull { sorted: (0..inputs).map(increasing).collect(), places: Vec::new() };
        let places = |input: usize| column(input).iter().map(|value| hull.place(input, *value)).collect();
        hull.places = (0..inputs).map(places).collect();
        hull
    }

    /// The place of a point among the runs: for each input between 0 and 1, and beyond if it is outside of their range.
    pub fn places(&self, row: &[f64]) -> Vec<f64> {
        row.iter().enumerate().map(|(input, value)| self.place(input, *value)).collect()
    }

    fn place(&self, input: usize, value: f64) -> f64 {
        let sorted = &self.sorted[input];
        let last = sorted.len() - 1;
        let (low, high) = (sorted[0], sorted[last]);
        let range = if high > low { high - low } else { 1.0 };
        if value < low {
            return self.place(input, low) - (low - value) / range;
        }
        if value > high {
            return self.place(input, high) + (value - high) / range;
        }
        let first = sorted.partition_point(|known| *known < value);
        let end = sorted.partition_point(|known| *known <= value);
        let place = if end > first {
            // The middle of those that are equal.
            0.5 * (first + end - 1) as f64
        } else {
            let (below, above) = (sorted[first - 1], sorted[first]);
            (first - 1) as f64 + (value - below) / (above - below)
        };
        place / last.max(1) as f64
    }

    /// The places of points in the rows of a graph. Values within rounding of that of a run are equal to it, since another program's logarithm may differ in the last bit, and the
    /// place jumps where several runs have the same value.
    pub fn onnx_places(&self, graph: &mut OnnxGraph, rows: &Value) -> Value {
        let mut places = Vec::with_capacity(self.sorted.len());
        for (input, sorted) in self.sorted.iter().enumerate() {
            let value = graph.columns(rows, &[input]);
            places.push(self.onnx_place(
                graph,
                sorted,
                [self.place(input, sorted[0]), self.place(input, sorted[sorted.len() - 1])],
                &value,
            ));
        }
        graph.beside(&places.iter().collect::<Vec<_>>())
    }

    fn onnx_place(&self, graph: &mut OnnxGraph, sorted: &[f64], ends: [f64; 2], value: &Value) -> Value {
        let last = sorted.len() - 1;
        let (low, high) = (sorted[0], sorted[last]);
        let range = if high > low { high - low } else { 1.0 };
        let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 0.0);
        let rounding = gaps.fold(ROUNDING * range, |least, gap| least.min(0.25 * gap));
        let numbers =
            [rounding, low, high, 1.0 / range, ends[0], ends[1], 0.5, 1.0, 1.0 / last.max(1) as f64];
        let [rounding, low, high, per_range, first_place, last_place, half, one, per_run] =
            numbers.map(|number| graph.number(number));
        let known = graph.row(sorted);
        let less = graph.apply("Sub", &[value, &rounding]);
        let more = graph.apply("Add", &[value, &rounding]);
        let is_below = graph.apply("Less", &[&known, &less]);
        let is_above = graph.apply("Greater", &[&known, &more]);
        let numbers = [&is_below, &is_above].map(|condition| {
            let numbers = graph.cast(condition, false);
            graph.sum_of_rows(&numbers)
        });
        let [count_below, count_above] = numbers;
        let runs = graph.number(sorted.len() as f64);
        // The number of runs that have the value.
        let equal = graph.apply("Sub", &[&runs, &count_below]);
        let equal = graph.apply("Sub", &[&equal, &count_above]);
        let is_equal = graph.apply("Greater", &[&equal, &half]);
        // The middle of those that are equal.
        let beyond = graph.apply("Sub", &[&equal, &one]);
        let beyond = graph.apply("Mul", &[&beyond, &half]);
        let middle = graph.apply("Add", &[&count_below, &beyond]);
        // Between the neighbours.
        let below = graph.apply("Where", &[&is_below, &known, &low]);
        let below = graph.extreme_of_rows("ReduceMax", &below);
        let above = graph.apply("Where", &[&is_above, &known, &high]);
        let above = graph.extreme_of_rows("ReduceMin", &above);
        let gap = graph.apply("Sub", &[&above, &below]);
        let has_gap = graph.apply("Greater", &[&gap, &rounding]);
        let gap = graph.apply("Where", &[&has_gap, &gap, &one]);
        let share = graph.apply("Sub", &[value, &below]);
        let share = graph.apply("Div", &[&share, &gap]);
        let between = graph.apply("Sub", &[&count_below, &one]);
        let between = graph.apply("Add", &[&between, &share]);
        let place = graph.apply("Where", &[&is_equal, &middle, &between]);
        let place = graph.apply("Mul", &[&place, &per_run]);
        // Beyond the ends.
        let beyond = |graph: &mut OnnxGraph, end: &Value, place_of_end: &Value| {
            let distance = graph.apply("Sub", &[value, end]);
            let distance = graph.apply("Mul", &[&distance, &per_range]);
            graph.apply("Add", &[place_of_end, &distance])
        };
        let before = beyond(graph, &low, &first_place);
        let after = beyond(graph, &high, &last_place);
        let is_before = graph.apply("Less", &[&more, &low]);
        let is_after = graph.apply("Greater", &[&less, &high]);
        let place = graph.apply("Where", &[&is_before, &before, &place]);
        graph.apply("Where", &[&is_after, &after, &place])
    }

    /// The distances of points, given by their places in the rows of a graph: a column.
    pub fn onnx_distance(&self, graph: &mut OnnxGraph, places: &Value) -> Value {
        let zero = graph.number(0.0);
        let inputs = self.places.len();
        let mut columns: Vec<Value> = Vec::with_capacity(inputs);
        for input in 0..inputs {
            columns.push(graph.columns(places, &[input]));
        }
        if let [place] = &columns[..] {
            let one = graph.number(1.0);
            let above = graph.apply("Sub", &[place, &one]);
            let below = graph.apply("Neg", &[place]);
            return graph.apply("Max", &[&above, &below, &zero]);
        }
        // For each input the signed differences from the runs.
        let mut apart: Vec<[Value; 2]> = Vec::with_capacity(inputs);
        for (place, known) in columns.iter().zip(&self.places) {
            let known = graph.row(known);
            let apart_of = graph.apply("Sub", &[place, &known]);
            let opposite = graph.apply("Neg", &[&apart_of]);
            apart.push([apart_of, opposite]);
        }
        let mut sides = vec![zero];
        for e in 0..inputs {
            for d in 0..e {
                for (x, y) in apart[d].iter().flat_map(|x| apart[e].iter().map(move |y| (x, y))) {
                    let side = graph.apply("Max", &[x, y]);
                    sides.push(graph.extreme_of_rows("ReduceMin", &side));
                }
            }
        }
        graph.apply("Max", &sides.iter().collect::<Vec<_>>())
    }

    /// The distance of a point, given by its places.
    pub fn distance(&self, places: &[f64]) -> HullDistance {
        self.distance_from(places, usize::MAX)
    }

    /// The distance of each run from the hull of the others.
    pub fn distances(&self) -> Vec<f64> {
        let runs = self.places.first().map_or(0, Vec::len);
        let own = |run: usize| self.places.iter().map(|places| places[run]).collect::<Vec<f64>>();
        (0..runs).map(|run| self.distance_from(&own(run), run).distance).collect()
    }

    /// The distance beyond which a point is outside.
    pub fn limit(&self) -> f64 {
        let mut distances = self.distances();
        distances.sort_by(f64::total_cmp);
        let within = ((1.0 - SHARE_OUTSIDE) * distances.len() as f64).ceil() as usize;
        distances.get(within.saturating_sub(1)).copied().unwrap_or(0.0)
    }

    fn distance_from(&self, places: &[f64], without: usize) -> HullDistance {
        let mut largest = HullDistance::default();
        if let [place] = places {
            largest.distance = (place - 1.0).max(-place).max(0.0);
        }
        for e in 0..places.len() {
            for d in 0..e {
                let distance = self.distance_in_plane([d, e], [places[d], places[e]], without);
                if distance > largest.distance {
                    largest = HullDistance { distance, pair: [d, e] };
                }
            }
        }
        largest
    }

    fn distance_in_plane(&self, [d, e]: [usize; 2], [x, y]: [f64; 2], without: usize) -> f64 {
        let mut least = [f64::INFINITY; 4];
        for (run, (known_x, known_y)) in self.places[d].iter().zip(&self.places[e]).enumerate() {
            if run == without {
                continue;
            }
            let (x, y) = (x - known_x, y - known_y);
            for (least, side) in least.iter_mut().zip([x.max(y), x.max(-y), (-x).max(y), (-x).max(-y)]) {
                *least = least.min(side);
            }
        }
        let largest = least.into_iter().fold(0.0, f64::max);
        if largest.is_finite() { largest } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a grid, but for those in its upper right corner.
    fn angle() -> OrthogonalHull {
        let grid = (0..20).flat_map(|i| (0..20).map(move |j| [f64::from(i), f64::from(j)]));
        let rows: Vec<f64> = grid.filter(|[x, y]| *x < 10.0 || *y < 10.0).flatten().collect();
        OrthogonalHull::new(&rows, 2)
    }

    #[test]
    fn a_corner_without_runs_is_outside_though_each_input_is_within_its_range() {
        let hull = angle();
        let distance = |row: [f64; 2]| hull.distance(&hull.places(&row));
        for inside in [[0.0, 0.0], [19.0, 9.0], [9.0, 19.0], [5.5, 5.5], [19.0, 0.0], [9.9, 9.0]] {
            assert_eq!(distance(inside).distance, 0.0, "{inside:?}");
        }
        let (near, far) = (distance([11.0, 11.0]), distance([18.0, 18.0]));
        assert!(0.0 < near.distance && near.distance < far.distance, "{near:?} {far:?}");
        assert_eq!(far.pair, [0, 1]);
        assert!(far.distance > hull.limit(), "{far:?} {}", hull.limit());
    }

    #[test]
    fn distance_goes_on_beyond_the_range() {
        let hull = angle();
        let beyond = |x: f64| hull.distance(&hull.places(&[x, 5.0])).distance;
        // Runs of the other ten columns of the grid are equally far in one of the quadrants, and those of the last are nearest.
        for (x, distance) in [(38.0, 1.0), (-9.5, 0.5)] {
            assert!((beyond(x) - distance).abs() < 1e-9, "{x} {}", beyond(x));
        }
        let line = OrthogonalHull::new(&[1.0, 2.0, 5.0], 1);
        let distance = |x: f64| line.distance(&line.places(&[x])).distance;
        assert_eq!((distance(3.0), distance(7.0), distance(0.0)), (0.0, 0.5, 0.25));
    }

    #[test]
    fn few_of_the_runs_are_outside_of_the_others() {
        // A sequence of low discrepancy (Roberts) in three inputs.
        let place = |k: usize, step: f64| (0.5 + step * k as f64).fract();
        let rows: Vec<f64> = (0..200)
            .flat_map(|k| {
                [0.819_172_513_396_1, 0.671_043_606_703_8, 0.549_700_477_901_7].map(|s| place(k, s))
            })
            .collect();
        let hull = OrthogonalHull::new(&rows, 3);
        let limit = hull.limit();
        let outside = hull.distances().iter().filter(|distance| **distance > limit).count();
        assert!((1..=4).contains(&outside), "{outside}");
        assert!(limit < 0.15, "{limit}");
    }

    #[test]
    fn equal_values_share_a_place() {
        let hull = OrthogonalHull::new(&[0.0, 0.0, 0.0, 1.0], 1);
        assert_eq!(hull.places(&[0.0]), [1.0 / 3.0]);
        assert_eq!(hull.places(&[1.0]), [1.0]);
    }
}
