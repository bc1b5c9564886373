//! Gaussian processes of curves in the graph of an ONNX file.
//!
//! A row asks for a point of a curve, which lies between two of the points at which curves are learned. All is computed at both of them, in a table with the rows for the
//! points before and then those for the points after, and interpolated.

use super::densities::Densities;
use super::failure::failed;
use super::fitted::{FEWEST_RUNS, FittedCurves};
use super::kept_curve::KeptCurve;
use super::onnx_densities::{OnnxCurve, onnx_densities};
use crate::error::Result;
use crate::onnx::{self, OnnxAnswer, OnnxEstimate, OnnxGraph, OnnxProcess, ProcessRows, Value};
use crate::surrogate::surrogate_trait::Surrogate;

/// The points before and after the coordinate of each row.
struct Ends {
    /// Their numbers, in a row of integers: those before, then those after.
    numbers: Value,
    /// How far the coordinate is from the first to the second, 0 to 1.
    share: Value,
}

impl Ends {
    fn new(graph: &mut OnnxGraph, points: &[f64], coordinate: &Value) -> Ends {
        let last = points.len().saturating_sub(1);
        let [zero, one, most] = [0.0, 1.0, last.saturating_sub(1) as f64].map(|value| graph.number(value));
        let known = graph.row(points);
        let is_below = graph.apply("Less", &[&known, coordinate]);
        let counts = graph.cast(&is_below, false);
        let count = graph.sum_of_rows(&counts);
        let before = graph.apply("Sub", &[&count, &one]);
        let before = graph.apply("Max", &[&before, &zero]);
        let before = graph.apply("Min", &[&before, &most]);
        let end = graph.number(last as f64);
        let after = graph.apply("Add", &[&before, &one]);
        let after = graph.apply("Min", &[&after, &end]);
        let numbers = graph.below(&[&before, &after]);
        let numbers = graph.shaped(&numbers, &[-1]);
        let numbers = graph.cast(&numbers, true);
        let places = graph.rows_of(points, 1, &numbers);
        let [first, second] = halves(graph, &places, 1);
        let width = graph.apply("Sub", &[&second, &first]);
        let has_width = graph.apply("Greater", &[&width, &zero]);
        let width = graph.apply("Where", &[&has_width, &width, &one]);
        let share = graph.apply("Sub", &[coordinate, &first]);
        let share = graph.apply("Div", &[&share, &width]);
        let share = graph.apply("Max", &[&share, &zero]);
        let share = graph.apply("Min", &[&share, &one]);
        Ends { numbers, share }
    }

    /// The rows of a table with a row for each point.
    fn rows(&self, graph: &mut OnnxGraph, table: &[f64], columns: usize) -> Value {
        graph.rows_of(table, columns, &self.numbers)
    }

    /// The same rows for the points before and after.
    fn twice(&self, graph: &mut OnnxGraph, table: &Value) -> Value {
        graph.below(&[table, table])
    }

    /// The values at the coordinate.
    fn between(&self, graph: &mut OnnxGraph, table: &Value, columns: usize) -> Value {
        let [first, second] = halves(graph, table, columns);
        let change = graph.apply("Sub", &[&second, &first]);
        let change = graph.apply("Mul", &[&change, &self.share]);
        graph.apply("Add", &[&first, &change])
    }
}

/// The upper and the lower half of the rows of a table.
fn halves(graph: &mut OnnxGraph, table: &Value, columns: usize) -> [Value; 2] {
    let both = graph.shaped(table, &[2, -1, columns as i64]);
    [0, 1].map(|half| {
        let half = graph.integers(&[half]);
        let rows = graph.apply_with("Gather", &[&both, &half], &[("axis", 0)]);
        graph.shaped(&rows, &[-1, columns as i64])
    })
}

/// What curves say of the rows of a table, with the intervals of a level, and a column that is 1 where the training runs do not have the combination of inputs.
///
/// # Errors
/// If a histogram has no curves.
pub(crate) fn onnx_curves(
    fitted: &FittedCurves,
    graph: &mut OnnxGraph,
    all: &Value,
    level: f64,
) -> Result<(OnnxAnswer, Option<Value>)> {
    let (kept, columns) = (&fitted.kept, fitted.columns());
    if kept.histograms.iter().any(|own| own.directions.is_empty()) {
        return Err(failed(
            "it has no ONNX form: a histogram that is the same in all of its runs has no curves",
        ));
    }
    // What most of the file is: a triangular matrix of each process, known before it is computed.
    let processes: usize = fitted.processes.iter().map(Vec::len).sum();
    let bytes = processes.saturating_mul(4).saturating_mul(kept.runs).saturating_mul(kept.runs);
    if bytes > onnx::MOST_BYTES {
        return Err(onnx::too_large(fitted.method(), bytes));
    }
    let (points, outputs) = (&kept.points, columns.outputs.len());
    let ranges = fitted.ranges();
    let coordinate = graph.columns(all, &[kept.coordinate]);
    let others: Vec<usize> = (0..columns.inputs.len()).filter(|input| *input != kept.coordinate).collect();
    // With the coordinate alone nothing refers to the others.
    let own = if others.is_empty() { coordinate.clone() } else { graph.columns(all, &others) };
    let groups: Vec<Value> = kept.groups.iter().map(|group| group.onnx(graph, &own)).collect();
    // Without groups there are no processes and no hull.
    let row = match &groups[..] {
        [] => coordinate.clone(),
        _ => graph.beside(&groups.iter().collect::<Vec<_>>()),
    };
    let ends = Ends::new(graph, points, &coordinate);

    let mut seen: Option<ProcessRows> = None;
    let mut curves = Vec::with_capacity(kept.curves.len());
    for (curve, processes) in kept.curves.iter().zip(&fitted.processes) {
        let mut weights = Vec::with_capacity(processes.len());
        let mut noises = Vec::with_capacity(processes.len());
        for process in processes {
            let seen = seen.get_or_insert_with(|| ProcessRows::new(graph, &row, process.parts().rows));
            weights.push(onnx::process(graph, seen, process));
            noises.push(process.noise());
        }
        curves.push(at_ends(graph, &ends, points, curve, (&weights, &noises), &own));
    }
    let curves = of_outputs(graph, curves, &kept.histograms, outputs);
    let means: Vec<&Value> = curves.iter().map(|curve| &curve.mean).collect();
    let means = graph.beside(&means);
    let means = ends.between(graph, &means, outputs);
    let outside = onnx::outside(graph, all, &ranges);
    let mut estimates: Vec<OnnxEstimate> = (0..outputs)
        .map(|output| OnnxEstimate { mean: graph.columns(&means, &[output]), spread: None })
        .collect();
    let hull = fitted.hull.as_ref().map(|hull| {
        let places = hull.onnx_places(graph, &row);
        let distance = hull.onnx_distance(graph, &places);
        (places, distance)
    });
    // One or two runs say nothing of their scatter.
    if kept.runs >= FEWEST_RUNS {
        let variances: Vec<Value> =
            curves.iter().map(|curve| graph.apply("Add", &[&curve.parameters, &curve.noise])).collect();
        let variances = graph.beside(&variances.iter().collect::<Vec<_>>());
        let variances = ends.between(graph, &variances, outputs);
        let deviations = graph.apply("Sqrt", &[&variances]);
        for (output, (estimate, calibration)) in estimates.iter_mut().zip(&kept.calibrations).enumerate() {
            let deviation = graph.columns(&deviations, &[output]);
            let factor = graph.number(calibration.interval(level));
            let mut half = graph.apply("Mul", &[&deviation, &factor]);
            if let (Some((places, distance)), Some(local)) = (&hull, kept.local.get(output)) {
                let local = local.onnx(graph, places, distance);
                half = graph.apply("Mul", &[&half, &local]);
            }
            estimate.spread = Some([deviation, half]);
        }
    }
    // In the plane of one input there is no combination.
    let limit = kept.limit.filter(|_| kept.groups.len() > 1);
    let unseen = hull.zip(limit).map(|((_, distance), limit)| {
        let limit = graph.number(limit);
        let is_unseen = graph.apply("Greater", &[&distance, &limit]);
        graph.cast(&is_unseen, false)
    });
    Ok((OnnxAnswer { estimates, outside, ranges }, unseen))
}

/// A curve at the points before and after.
fn at_ends(
    graph: &mut OnnxGraph,
    ends: &Ends,
    points: &[f64],
    curve: &KeptCurve,
    (weights, noises): (&[OnnxProcess], &[f64]),
    inputs: &Value,
) -> OnnxCurve {
    // Without inputs that vary there are components, but no processes of their weights.
    let components = &curve.components[..weights.len()];
    let count = components.len();
    let mut mean = ends.rows(graph, &curve.mean, 1);
    if let Some(input) = curve.start {
        let start = graph.columns(inputs, &[input]);
        let start = ends.twice(graph, &start);
        let kept: Vec<[f64; 2]> = points
            .iter()
            .map(|x| {
                // What is left of the start, and what is in the place of the rest, since it is linear in the start.
                let at = |start: f64| curve.memory.map_or(start, |memory| memory.value(start, x - points[0]));
                [at(1.0) - at(0.0), at(0.0)]
            })
            .collect();
        let kept = ends.rows(graph, kept.as_flattened(), 2);
        let [share, rest] = [0, 1].map(|column| graph.columns(&kept, &[column]));
        let start = graph.apply("Mul", &[&start, &share]);
        let start = graph.apply("Add", &[&start, &rest]);
        mean = graph.apply("Add", &[&mean, &start]);
    }
    let squares = |point: usize| components.iter().map(move |component| component[point] * component[point]);
    let noise = |point: usize| squares(point).zip(noises).map(|(square, noise)| square * noise).sum::<f64>();
    let noise: Vec<f64> = (0..points.len()).map(|point| curve.rest[point] + noise(point)).collect();
    let noise = ends.rows(graph, &noise, 1);
    let mut parameters = {
        let zero = graph.number(0.0);
        graph.apply("Mul", &[&noise, &zero])
    };
    if count > 0 {
        let table: Vec<f64> = (0..points.len())
            .flat_map(|point| components.iter().map(move |component| component[point]))
            .collect();
        let own = ends.rows(graph, &table, count);
        let means = graph.beside(&weights.iter().map(|weight| &weight.mean).collect::<Vec<_>>());
        let means = ends.twice(graph, &means);
        let sum = graph.apply("Mul", &[&own, &means]);
        let sum = graph.sum_of_rows(&sum);
        mean = graph.apply("Add", &[&mean, &sum]);
        let squares = graph.apply("Mul", &[&own, &own]);
        let variances = graph.beside(&weights.iter().map(|weight| &weight.variance).collect::<Vec<_>>());
        let variances = ends.twice(graph, &variances);
        let sum = graph.apply("Mul", &[&squares, &variances]);
        parameters = graph.sum_of_rows(&sum);
    }
    let curve_at_ends = OnnxCurve { mean, parameters, noise };
    if curve.root { squared(graph, curve_at_ends) } else { curve_at_ends }
}

/// The output, from the curve of its root.
fn squared(graph: &mut OnnxGraph, root: OnnxCurve) -> OnnxCurve {
    let [two, four] = [2.0, 4.0].map(|value| graph.number(value));
    let variance = graph.apply("Add", &[&root.parameters, &root.noise]);
    let square = graph.apply("Mul", &[&root.mean, &root.mean]);
    let factor = graph.apply("Mul", &[&square, &four]);
    let twice = graph.apply("Mul", &[&variance, &two]);
    let factor = graph.apply("Add", &[&factor, &twice]);
    let mean = graph.apply("Add", &[&square, &variance]);
    let [parameters, noise] =
        [&root.parameters, &root.noise].map(|part| graph.apply("Mul", &[part, &factor]));
    OnnxCurve { mean, parameters, noise }
}

/// The curves of all outputs: those of the bins of a histogram are put together from its coefficients.
fn of_outputs(
    graph: &mut OnnxGraph,
    curves: Vec<OnnxCurve>,
    histograms: &[Densities],
    outputs: usize,
) -> Vec<OnnxCurve> {
    let mut curves = curves.into_iter();
    let mut found = Vec::with_capacity(outputs);
    while found.len() < outputs {
        match histograms.iter().find(|densities| densities.first == found.len()) {
            Some(densities) => {
                let own: Vec<OnnxCurve> = curves.by_ref().take(densities.directions.len()).collect();
                found.extend(onnx_densities(graph, densities, &own));
            }
            None => match curves.next() {
                Some(curve) => found.push(curve),
                None => break,
            },
        }
    }
    found
}
