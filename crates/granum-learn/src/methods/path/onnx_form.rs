//! A step of networks with a state along a path in the graph of an ONNX file: what [`super::steps::PathSteps`] says of the next row, with a memory of a fixed size.
//!
//! The memory has, one after the other: the row before, the sum of all increments with the length of the path and the largest distance from its start so far, the size of errors
//! for the sample, the increments that a window sees beside the present one (the last one first, zeros before the first row), and the states of each network in each rotation.

use super::cell::PathCell;
use super::channels::{Channels, LEAST, MEAN_LENGTH};
use super::errors::PathErrors;
use super::fitted::{FittedPath, ROUNDING};
use super::onnx_rotations::OnnxRotations;
use super::onnx_terms::{outputs, starts, units};
use crate::methods::onnx_memory::OnnxMemory;
use crate::onnx::{self, OnnxEstimate, OnnxGraph, Value};

/// Adds a step to a graph, with the intervals of a level.
pub(super) fn onnx_step(fitted: &FittedPath, graph: &mut OnnxGraph, level: f64) {
    let (columns, channels) = (&fitted.columns, &fitted.channels);
    let widths = channels.widths();
    let (inputs, components) = (columns.inputs.len(), widths.increment() - 1);
    let row = onnx::inputs(graph, columns);
    onnx::state_ranges(graph, columns, &fitted.ranges);
    let rotations = fitted.rotations();
    let rotations = OnnxRotations::new(&rotations, widths);
    let earlier = fitted.sizes.increments_seen() - 1;
    let states = fitted.networks.iter().map(|network| rotations.count() * network.state_values());
    let sizes = fitted.errors.as_ref().map_or(0, |_| columns.outputs.len());
    let width = inputs + components + 2 + sizes + earlier * components + states.sum::<usize>();
    let mut memory = OnnxMemory::new(graph, width);

    let starts = starts(graph, channels, &row, inputs);
    let increment = increment(graph, channels, &row, inputs, &mut memory);
    let place = Place::new(graph, components, &increment, &mut memory);
    let sizes =
        fitted.errors.as_ref().map(|errors| sizes_of_errors(graph, fitted, errors, &starts, &mut memory));
    let seen = seen(graph, fitted, &rotations, &increment, &mut memory);

    let turned = rotations.starts(graph, &starts);
    let mut answers = Vec::with_capacity(fitted.networks.len());
    for network in &fitted.networks {
        let width = network.state_values() as i64;
        let before = memory.next(graph, rotations.count() * network.state_values());
        let all = rotations.count() as i64 * width;
        let first = network.first_state(graph, &turned);
        let first = graph.shaped(&first, &[-1, all]);
        let state = graph.apply("Where", &[&memory.begins, &first, &before]);
        let state = graph.shaped(&state, &[-1, width]);
        let step = network.advance(graph, &seen, &state);
        let after = graph.shaped(&step.state, &[-1, all]);
        memory.keep(&after);
        let mean = rotations.mean(graph, &step.outputs);
        answers.push(outputs(graph, channels, &mean, columns.outputs.len()));
    }
    let units = fitted.errors.as_ref().and_then(|_| units(graph, channels, &answers, columns.outputs.len()));
    memory.write(graph);

    let factors = fitted.errors.as_ref().map(|errors| errors.factors(level));
    let known = fitted.errors.as_ref().zip(sizes).zip(factors);
    let estimate = |graph: &mut OnnxGraph, output: usize| match &known {
        Some(((errors, sizes), factors)) => {
            let size = graph.columns(sizes, &[output]);
            let unit = units.as_ref().map(|units| graph.columns(units, &[output]));
            let by = (&size, unit.as_ref(), factors[output]);
            errors.onnx_estimate(graph, &answers, output, [&place.length, &place.farthest], by)
        }
        None => {
            let [mean, _] = onnx::mean_and_variance(graph, &answers, output);
            OnnxEstimate { mean, spread: None }
        }
    };
    let estimates: Vec<OnnxEstimate> =
        (0..columns.outputs.len()).map(|output| estimate(graph, output)).collect();
    let mut outside = onnx::outside(graph, &row, &fitted.ranges);
    if let Some(errors) = &fitted.errors {
        let beyond = place.beyond(graph, errors);
        outside = graph.apply("Max", &[&outside, &beyond]);
    }
    onnx::outputs(graph, columns, &estimates, &outside);
}

/// The increments that lead to rows.
fn increment(
    graph: &mut OnnxGraph,
    channels: &Channels,
    row: &Value,
    inputs: usize,
    memory: &mut OnnxMemory,
) -> Value {
    let before = memory.next(graph, inputs);
    memory.keep(row);
    let zero_first = channels.begin_at_zero(inputs);
    let kept: Vec<f64> = zero_first.iter().map(|is_zero| f64::from(u8::from(!is_zero))).collect();
    let kept = graph.row(&kept);
    // Before the first row strains are zero, and all else is what it is in this row.
    let first = graph.apply("Mul", &[row, &kept]);
    let last = graph.apply("Where", &[&memory.begins, &first, &before]);
    let change = graph.apply("Sub", &[row, &last]);
    // Increments are linear in the change of the row, so that those of unit changes are the factors.
    let origin = vec![0.0; inputs];
    let unit = |place: usize| (0..inputs).map(|k| f64::from(u8::from(k == place))).collect::<Vec<f64>>();
    let factors: Vec<f64> =
        (0..inputs).flat_map(|place| channels.increment(Some(&origin), &unit(place))).collect();
    graph.linear(&change, inputs, &factors, None)
}

/// The norm of each row.
fn norms(graph: &mut OnnxGraph, table: &Value) -> Value {
    let squares = graph.apply("Mul", &[table, table]);
    let squares = graph.sum_of_rows(&squares);
    graph.apply("Sqrt", &[&squares])
}

/// How far the path is.
struct Place {
    length: Value,
    farthest: Value,
}

impl Place {
    fn new(graph: &mut OnnxGraph, components: usize, increment: &Value, memory: &mut OnnxMemory) -> Place {
        let sum = memory.next_or_zero(graph, components);
        let sum = graph.apply("Add", &[&sum, increment]);
        memory.keep(&sum);
        let length = memory.next_or_zero(graph, 1);
        let own = norms(graph, increment);
        let length = graph.apply("Add", &[&length, &own]);
        memory.keep(&length);
        let farthest = memory.next_or_zero(graph, 1);
        let distance = norms(graph, &sum);
        let farthest = graph.apply("Max", &[&farthest, &distance]);
        memory.keep(&farthest);
        Place { length, farthest }
    }

    /// A column that is 1 where the path is longer than that of any training run, or turns more often.
    fn beyond(&self, graph: &mut OnnxGraph, errors: &PathErrors) -> Value {
        let longest = graph.number((1.0 + ROUNDING) * errors.longest());
        let mut beyond = graph.apply("Greater", &[&self.length, &longest]);
        if errors.largest_ratio() > 0.0 {
            let most = graph.number((1.0 + ROUNDING) * errors.largest_ratio());
            let most = graph.apply("Mul", &[&self.farthest, &most]);
            let turns = graph.apply("Greater", &[&self.length, &most]);
            beyond = graph.apply("Or", &[&beyond, &turns]);
        }
        onnx::any(graph, &beyond)
    }
}

/// How large errors are for the sample, which its first row tells: a column for each output.
fn sizes_of_errors(
    graph: &mut OnnxGraph,
    fitted: &FittedPath,
    errors: &PathErrors,
    starts: &Value,
    memory: &mut OnnxMemory,
) -> Value {
    let known = memory.next(graph, fitted.columns.outputs.len());
    let widths = fitted.channels.widths();
    let scalars = onnx::part(graph, starts, widths.starts() - widths.start_scalars, widths.start_scalars);
    let first = match scalars.and_then(|samples| errors.onnx_sizes(graph, &samples)) {
        Some(sizes) => sizes,
        None => {
            let sizes = errors.sizes(&[vec![0.0; widths.start_scalars]]).concat();
            graph.row(&sizes)
        }
    };
    let sizes = graph.apply("Where", &[&memory.begins, &first, &known]);
    memory.keep(&sizes);
    sizes
}

/// What networks see of the increments: a row for each rotation of each row of increments.
fn seen(
    graph: &mut OnnxGraph,
    fitted: &FittedPath,
    rotations: &OnnxRotations,
    increment: &Value,
    memory: &mut OnnxMemory,
) -> Value {
    let components = fitted.channels.widths().increment() - 1;
    let numbers = [1.0 / fitted.channels.mean_length(), LEAST, MEAN_LENGTH, 10.0, 0.0, 1.0];
    let [per_length, least, mean, ten, zero, one] = numbers.map(|value| graph.number(value));
    let norm = norms(graph, increment);
    let relative = graph.apply("Mul", &[&norm, &per_length]);
    let moves = graph.apply("Greater", &[&relative, &least]);
    let divisor = graph.apply("Where", &[&moves, &norm, &one]);
    let direction = graph.apply("Div", &[increment, &divisor]);
    let direction = graph.apply("Where", &[&moves, &direction, &zero]);
    let length = graph.apply("Mul", &[&relative, &mean]);
    let length = graph.apply("Where", &[&moves, &length, &zero]);
    let factor = graph.apply("Mul", &[&length, &ten]);
    let vector = graph.apply("Mul", &[&direction, &factor]);
    if matches!(fitted.sizes.cell, PathCell::Gru | PathCell::Lstm) {
        return rotations.directions(graph, &vector, 1);
    }
    let length = rotations.repeated(graph, &length, 1);
    let direction = rotations.directions(graph, &direction, 1);
    let earlier = fitted.sizes.increments_seen() - 1;
    if earlier == 0 {
        return graph.beside(&[&length, &direction]);
    }
    let before = memory.next_or_zero(graph, earlier * components);
    let older = onnx::part(graph, &before, 0, (earlier - 1) * components);
    let kept: Vec<&Value> = [&vector].into_iter().chain(&older).collect();
    memory.keep(&graph.beside(&kept));
    let before = rotations.directions(graph, &before, earlier);
    graph.beside(&[&length, &direction, &before])
}
