//! Histograms in the graph of an ONNX file.

use super::densities::{Densities, STEPS};
use crate::onnx::{OnnxGraph, Value};

/// A predicted curve at the points: columns.
#[derive(Clone)]
pub(super) struct OnnxCurve {
    pub mean: Value,
    pub parameters: Value,
    pub noise: Value,
}

/// The densities of the bins, a curve each, from the coefficients.
pub(super) fn onnx_densities(
    graph: &mut OnnxGraph,
    densities: &Densities,
    coefficients: &[OnnxCurve],
) -> Vec<OnnxCurve> {
    let (shares, count) = (densities.mean.len(), coefficients.len());
    let directions = densities.directions.concat();
    let squares: Vec<f64> = directions.iter().map(|value| value * value).collect();
    let table = |graph: &mut OnnxGraph, of: fn(&OnnxCurve) -> &Value| {
        graph.beside(&coefficients.iter().map(of).collect::<Vec<_>>())
    };
    let means = table(graph, |own| &own.mean);
    let roots = graph.linear(&means, count, &directions, Some(&densities.mean));
    let parameters = table(graph, |own| &own.parameters);
    let parameters = graph.linear(&parameters, count, &squares, None);
    let noise = table(graph, |own| &own.noise);
    let noise = graph.linear(&noise, count, &squares, Some(&densities.rest));
    let square = graph.apply("Mul", &[&roots, &roots]);
    let whole = graph.apply("Add", &[&square, &noise]);
    let whole = normalised(graph, densities, &whole);
    // With the variance s of a normal root r, that of its square is 4 r^2 s + 2 s^2.
    let all = graph.apply("Add", &[&parameters, &noise]);
    let [two, four, per_width, per_area] =
        [2.0, 4.0, 1.0 / densities.width, 1.0 / (densities.width * densities.width)]
            .map(|value| graph.number(value));
    let factor = graph.apply("Mul", &[&square, &four]);
    let twice = graph.apply("Mul", &[&all, &two]);
    let factor = graph.apply("Add", &[&factor, &twice]);
    let factor = graph.apply("Mul", &[&factor, &per_area]);
    let mean = graph.apply("Mul", &[&whole, &per_width]);
    let [parameters, noise] = [&parameters, &noise].map(|part| graph.apply("Mul", &[part, &factor]));
    (0..shares - 1)
        .map(|bin| {
            let [mean, parameters, noise] =
                [&mean, &parameters, &noise].map(|table| graph.columns(table, &[bin]));
            OnnxCurve { mean, parameters, noise }
        })
        .collect()
}

/// Rows over their sums; of a sum that is not positive they stay as they are.
fn over_sum(graph: &mut OnnxGraph, rows: &Value) -> Value {
    let [zero, one] = [0.0, 1.0].map(|value| graph.number(value));
    let sum = graph.sum_of_rows(rows);
    let is_positive = graph.apply("Greater", &[&sum, &zero]);
    let sum = graph.apply("Where", &[&is_positive, &sum, &one]);
    graph.apply("Div", &[rows, &sum])
}

/// Shares with the sum one and, where it is known, the mean one. All steps of the search for the tilt are written out one after the other: those after it is found change nothing.
fn normalised(graph: &mut OnnxGraph, densities: &Densities, shares: &Value) -> Value {
    let shares = over_sum(graph, shares);
    if densities.values.is_empty() {
        return shares;
    }
    let apart: Vec<f64> = densities.values.iter().map(|value| value - 1.0).collect();
    let powers: Vec<f64> = apart.iter().flat_map(|c| [*c, c * c]).collect();
    let [zero, half, minus_half] = [0.0, 0.5, -0.5].map(|value| graph.number(value));
    let minus_apart: Vec<f64> = apart.iter().map(|c| -c).collect();
    let minus_apart = graph.row(&minus_apart);
    let first = graph.columns(&shares, &[0]);
    let mut tilt = graph.apply("Mul", &[&first, &zero]);
    let tilted = |graph: &mut OnnxGraph, tilt: &Value| {
        let exponents = graph.apply("Mul", &[tilt, &minus_apart]);
        let factors = graph.apply("Exp", &[&exponents]);
        graph.apply("Mul", &[&shares, &factors])
    };
    for _ in 0..STEPS {
        let own = tilted(graph, &tilt);
        // The sum, which both moments have below them, drops out of their ratio.
        let moments = graph.linear(&own, apart.len(), &powers, None);
        let [first, second] = [0, 1].map(|moment| graph.columns(&moments, &[moment]));
        let is_positive = graph.apply("Greater", &[&second, &zero]);
        let step = graph.apply("Div", &[&first, &second]);
        let step = graph.apply("Where", &[&is_positive, &step, &zero]);
        let step = graph.apply("Max", &[&step, &minus_half]);
        let step = graph.apply("Min", &[&step, &half]);
        tilt = graph.apply("Add", &[&tilt, &step]);
    }
    let own = tilted(graph, &tilt);
    over_sum(graph, &own)
}
