//! The inputs of a surrogate as inputs of a graph, and its estimates as outputs, with the names of the table of predictions.

use crate::dataset::Variable;
use crate::onnx::{OnnxGraph, Value};
use crate::surrogate::{Columns, possible_values};

/// The estimate of an output: a table of one column each.
pub struct OnnxEstimate {
    /// The mean.
    pub mean: Value,
    /// The standard deviation, and the half width of the interval, which is cut to what the output can be; `None` without an interval.
    pub spread: Option<[Value; 2]>,
}

/// What a surrogate without memory predicts for the rows of a table.
pub struct OnnxAnswer {
    /// The estimate of each output.
    pub estimates: Vec<OnnxEstimate>,
    /// A column that is 1 where a row is outside of what the surrogate was fitted to, and 0 elsewhere.
    pub outside: Value,
    /// The trained range of each input.
    pub ranges: Vec<[f64; 2]>,
}

/// The inputs of a surrogate, one table of one column each by its name, as one table in their order.
pub fn inputs(graph: &mut OnnxGraph, columns: &Columns) -> Value {
    let each: Vec<Value> =
        columns.inputs.iter().map(|input| graph.input(&input.name, 1, &unit(input))).collect();
    graph.beside(&each.iter().collect::<Vec<_>>())
}

fn unit(variable: &Variable) -> String {
    let unit = if variable.unit.is_empty() { "1" } else { &variable.unit };
    format!("{} in {unit}", variable.name)
}

/// A column that is 1 where an input is outside its trained range, and 0 elsewhere.
pub fn outside(graph: &mut OnnxGraph, inputs: &Value, ranges: &[[f64; 2]]) -> Value {
    let [lows, highs] = [0, 1].map(|end| ranges.iter().map(|range| range[end]).collect::<Vec<f64>>());
    let (lows, highs) = (graph.row(&lows), graph.row(&highs));
    let (below, above) = (graph.apply("Less", &[inputs, &lows]), graph.apply("Greater", &[inputs, &highs]));
    let beyond = graph.apply("Or", &[&below, &above]);
    any(graph, &beyond)
}

/// A column that is 1 where a condition holds in any column of a row.
pub fn any(graph: &mut OnnxGraph, condition: &Value) -> Value {
    let numbers = graph.cast(condition, false);
    let count = graph.sum_of_rows(&numbers);
    let one = graph.number(1.0);
    graph.apply("Min", &[&count, &one])
}

/// The mean of the answers of several networks for an output, and the variance between them.
pub fn mean_and_variance(graph: &mut OnnxGraph, answers: &[Value], output: usize) -> [Value; 2] {
    let each: Vec<Value> = answers.iter().map(|answer| graph.columns(answer, &[output])).collect();
    let table = graph.beside(&each.iter().collect::<Vec<_>>());
    let [share, per_network] =
        [answers.len() as f64, (answers.len() as f64 - 1.0).max(1.0)].map(|count| graph.number(1.0 / count));
    let sum = graph.sum_of_rows(&table);
    let mean = graph.apply("Mul", &[&sum, &share]);
    let apart = graph.apply("Sub", &[&table, &mean]);
    let squares = graph.apply("Mul", &[&apart, &apart]);
    let squares = graph.sum_of_rows(&squares);
    let between = graph.apply("Mul", &[&squares, &per_network]);
    [mean, between]
}

/// A standard deviation with the half width of an interval of so many of them.
pub fn spread(graph: &mut OnnxGraph, deviation: Option<Value>, quantile: f64) -> Option<[Value; 2]> {
    let deviation = deviation?;
    let quantile = graph.number(quantile);
    let half = graph.apply("Mul", &[&deviation, &quantile]);
    Some([deviation, half])
}

/// Gives the estimates of all outputs, whose intervals are cut to what can be, and the column `outside`.
pub fn outputs(graph: &mut OnnxGraph, columns: &Columns, estimates: &[OnnxEstimate], outside: &Value) {
    let possible: Vec<[f64; 2]> =
        columns.outputs.iter().map(|output| possible_values(&output.name)).collect();
    outputs_within(graph, columns, estimates, outside, &possible);
}

/// The same where it is told what each output can be.
pub fn outputs_within(
    graph: &mut OnnxGraph,
    columns: &Columns,
    estimates: &[OnnxEstimate],
    outside: &Value,
    possible: &[[f64; 2]],
) {
    for ((output, estimate), [low, high]) in columns.outputs.iter().zip(estimates).zip(possible) {
        let (name, what) = (&output.name, unit(output));
        let mean = &estimate.mean;
        graph.output(&format!("predicted_{name}"), 1, &what, mean);
        let Some([deviation, half]) = &estimate.spread else { continue };
        graph.output(&format!("standard_deviation_{name}"), 1, &what, deviation);
        for (end, operator, limit, outward, inward) in
            [("lower", "Sub", *low, "Max", "Min"), ("upper", "Add", *high, "Min", "Max")]
        {
            let mut value = graph.apply(operator, &[mean, half]);
            if limit.is_finite() {
                let limit = graph.number(limit);
                let limit = graph.apply(inward, &[&limit, mean]);
                value = graph.apply(outward, &[&value, &limit]);
            }
            graph.output(&format!("{end}_{name}"), 1, &what, &value);
        }
    }
    graph.output("outside", 1, "1 if an input is outside its trained range", outside);
}

/// States the trained ranges of the inputs.
pub fn state_ranges(graph: &mut OnnxGraph, columns: &Columns, ranges: &[[f64; 2]]) {
    for (input, [low, high]) in columns.inputs.iter().zip(ranges) {
        graph.state(&format!("trained_range.{}", input.name), format!("[{low:?}, {high:?}]"));
    }
}
