//! Curves between points.

use super::graph::{OnnxGraph, Value};

/// The value of a curve at the places in a column, linear between points with `xs` that increase, constant beyond them: the first value with the change over
/// the part of each interval that is passed.
pub fn interpolated(graph: &mut OnnxGraph, places: &Value, xs: &[f64], ys: &[f64]) -> Value {
    let pairs = || xs.windows(2).zip(ys.windows(2));
    let slopes: Vec<f64> = pairs().map(|(x, y)| (y[1] - y[0]) / (x[1] - x[0])).collect();
    let widths: Vec<f64> = pairs().map(|(x, _)| x[1] - x[0]).collect();
    let first = graph.number(ys.first().copied().unwrap_or(f64::NAN));
    let zero = graph.number(0.0);
    if slopes.is_empty() {
        let zeros = graph.apply("Mul", &[places, &zero]);
        return graph.apply("Add", &[&zeros, &first]);
    }
    let (begins, widths) = (graph.row(&xs[..widths.len()]), graph.row(&widths));
    let beyond = graph.apply("Sub", &[places, &begins]);
    let beyond = graph.apply("Max", &[&beyond, &zero]);
    let within = graph.apply("Min", &[&beyond, &widths]);
    let change = graph.linear(&within, slopes.len(), &slopes, None);
    graph.apply("Add", &[&change, &first])
}
