//! How large the errors of the runs are that are most alike.
//!
//! Each training run has a weight that falls with its distance from the place at hand,
//!
//! ```text
//! w_i = exp(-|u - u_i|^2 / (2 h^2))
//! ```
//!
//! where the width `h` is the one with which the weights are worth an eighth of all runs, and 24 at least: where runs are sparse, farther ones count.
//! The size of errors is the root of the weighted mean of their squares. Source: Guan, Localized conformal prediction: a generalized inference framework for conformal prediction,
//! Biometrika 110 (2023).

use crate::onnx::{OnnxGraph, Value};

/// Share of the training runs that the weights are worth.
const SHARE: f64 = 0.125;
/// The least number of runs that they are worth.
const FEWEST: f64 = 24.0;
/// Number of halvings of the interval in which the width is sought.
const HALVINGS: usize = 40;
/// The narrowest and the widest width, in parts of the range of all runs.
const WIDTHS: [f64; 2] = [1e-3, 1e2];

/// The weight of each training run at a place, or at that of a training run without its own.
pub(super) fn weights(runs: &[Vec<f64>], place: &[f64], without: Option<usize>) -> Vec<f64> {
    let square = |run: &Vec<f64>| run.iter().zip(place).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let squares: Vec<f64> = runs.iter().map(square).collect();
    let weight = |run: usize, width: f64| match without {
        Some(own) if own == run => 0.0,
        _ => libm::exp(-squares[run] / (2.0 * width * width)),
    };
    let [mut narrow, mut wide] = WIDTHS;
    let needed = needed(runs.len());
    for _ in 0..HALVINGS {
        let width = (narrow * wide).sqrt();
        let worth: f64 = (0..runs.len()).map(|run| weight(run, width)).sum();
        if worth < needed { narrow = width } else { wide = width }
    }
    (0..runs.len()).map(|run| weight(run, wide)).collect()
}

/// What the weights of so many runs are worth.
fn needed(runs: usize) -> f64 {
    (SHARE * runs as f64).max(FEWEST)
}

/// The weights at the places in the rows of a graph, a column for each training run. The halvings are written out one after the other.
pub(super) fn onnx_weights(graph: &mut OnnxGraph, runs: &[Vec<f64>], places: &Value) -> Value {
    let values = runs.first().map_or(0, Vec::len);
    let known = graph.constant(&[1, runs.len(), values], &runs.concat());
    let places = graph.shaped(places, &[-1, 1, values as i64]);
    let apart = graph.apply("Sub", &[&places, &known]);
    let apart = graph.apply("Mul", &[&apart, &apart]);
    let axis = graph.integers(&[2]);
    let squares = graph.apply_with("ReduceSum", &[&apart, &axis], &[("keepdims", 0)]);
    let minus_half = graph.number(-0.5);
    let exponents = graph.apply("Mul", &[&squares, &minus_half]);
    let weights = |graph: &mut OnnxGraph, width: &Value| {
        let square = graph.apply("Mul", &[width, width]);
        let exponents = graph.apply("Div", &[&exponents, &square]);
        graph.apply("Exp", &[&exponents])
    };
    let [mut narrow, mut wide] = WIDTHS.map(|width| graph.number(width));
    // Fewer runs than are needed count with the widest width, whatever the place is.
    if runs.len() as f64 >= FEWEST {
        let needed = graph.number(needed(runs.len()));
        for _ in 0..HALVINGS {
            let product = graph.apply("Mul", &[&narrow, &wide]);
            let width = graph.apply("Sqrt", &[&product]);
            let own = weights(graph, &width);
            let worth = graph.sum_of_rows(&own);
            let is_narrow = graph.apply("Less", &[&worth, &needed]);
            narrow = graph.apply("Where", &[&is_narrow, &width, &narrow]);
            wide = graph.apply("Where", &[&is_narrow, &wide, &width]);
        }
    }
    weights(graph, &wide)
}

/// The result of [`size`] in a graph, for weights in rows.
pub(super) fn onnx_size(graph: &mut OnnxGraph, weights: &Value, squares: &[f64]) -> Value {
    let sum = graph.sum_of_rows(weights);
    let weighted = graph.linear(weights, squares.len(), squares, None);
    let mean = graph.apply("Div", &[&weighted, &sum]);
    let [zero, one] = [0.0, 1.0].map(|value| graph.number(value));
    let is_positive = graph.apply("Greater", &[&mean, &zero]);
    let root = graph.apply("Sqrt", &[&mean]);
    graph.apply("Where", &[&is_positive, &root, &one])
}

/// The root of the weighted mean of the squares; one if there are none.
pub(super) fn size(weights: &[f64], squares: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    let mean = weights.iter().zip(squares).map(|(w, square)| w * square).sum::<f64>() / sum;
    if mean > 0.0 && mean.is_finite() { mean.sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(runs: usize) -> Vec<Vec<f64>> {
        (0..runs).map(|run| vec![run as f64 / (runs - 1) as f64]).collect()
    }

    #[test]
    fn an_eighth_of_the_runs_counts_at_the_end_as_in_the_middle() {
        let runs = line(400);
        for place in [0.0, 0.3, 0.5, 1.0] {
            let weights = weights(&runs, &[place], None);
            let worth: f64 = weights.iter().sum();
            assert!((worth - 50.0).abs() < 1e-6, "{worth}");
            let farthest = (0..400).max_by(|a, b| weights[*b].total_cmp(&weights[*a])).unwrap();
            assert!((runs[farthest][0] - place).abs() >= 0.5);
        }
        assert_eq!(weights(&runs, &[0.5], Some(200))[200], 0.0);
    }

    #[test]
    fn the_size_of_errors_follows_a_step() {
        let runs = line(400);
        let squares: Vec<f64> = runs.iter().map(|run| if run[0] < 0.5 { 1.0 } else { 9.0 }).collect();
        let at = |place: f64| size(&weights(&runs, &[place], None), &squares);
        assert!((at(0.2) - 1.0).abs() < 0.01 && (at(0.8) - 3.0).abs() < 0.01);
        assert!((at(0.5) - 5f64.sqrt()).abs() < 0.05);
    }

    #[test]
    fn few_runs_or_runs_at_one_place_count_alike() {
        let alike = |weights: &[f64]| weights.iter().all(|weight| (weight - weights[0]).abs() < 1e-3);
        assert!(alike(&weights(&line(20), &[0.1], None)));
        assert!(alike(&weights(&vec![vec![0.5]; 400], &[0.5], None)));
        assert!(alike(&weights(&vec![Vec::new(); 400], &[], None)));
        assert_eq!(size(&[1.0, 1.0], &[0.0, 0.0]), 1.0);
    }
}
