//! A step of gated recurrent units as a graph, with their memories as an input and an output.

use granum_nets::{GruWeights, SequenceModel};

use super::graph::{OnnxGraph, Value};
use super::network::{scaled, unscaled};

/// The outputs of a unit for a row, and its memory after it.
pub struct OnnxStep {
    /// The outputs in their units.
    pub outputs: Value,
    /// The memory after the row.
    pub memory: Value,
}

/// A step of a unit for a table of its inputs in their units. Where the condition `begins` holds, a sequence begins, and its memory comes from the inputs.
pub fn step(
    graph: &mut OnnxGraph,
    model: &SequenceModel,
    inputs: &Value,
    memory: &Value,
    begins: &Value,
) -> OnnxStep {
    let x = scaled(graph, model.input_scalers(), inputs);
    let (columns, hidden) = (model.inputs().len(), model.gru().hidden());
    let GruWeights { gates, candidate_inputs, candidate_state, read_out, first_state } = model.gru().parts();
    let first = affine(graph, &x, first_state, columns, columns);
    let first = graph.apply("Tanh", &[&first]);
    let before = graph.apply("Where", &[begins, &first, memory]);
    let (reset_rows, update_rows) = gates.split_at(gates.len() / 2);
    let gate = |graph: &mut OnnxGraph, rows: &[f64]| {
        // The weights of the inputs, the bias, the weights of the memory.
        let both = graph.beside(&[&x, &before]);
        let row = columns + 1 + hidden;
        let plain: Vec<f64> = without(rows, row, columns);
        let bias: Vec<f64> = rows.chunks_exact(row).map(|weights| weights[columns]).collect();
        let sums = graph.linear(&both, columns + hidden, &transposed(&plain, columns + hidden), Some(&bias));
        graph.apply("Sigmoid", &[&sums])
    };
    let (reset, update) = (gate(graph, reset_rows), gate(graph, update_rows));
    let from_inputs = affine(graph, &x, candidate_inputs, columns, columns);
    let held = affine(graph, &before, candidate_state, hidden, 0);
    let held = graph.apply("Mul", &[&reset, &held]);
    let candidate = graph.apply("Add", &[&held, &from_inputs]);
    let candidate = graph.apply("Tanh", &[&candidate]);
    let difference = graph.apply("Sub", &[&before, &candidate]);
    let kept = graph.apply("Mul", &[&update, &difference]);
    let memory = graph.apply("Add", &[&kept, &candidate]);
    let outputs = affine(graph, &memory, read_out, hidden, 0);
    OnnxStep { outputs: unscaled(graph, model.output_scalers(), &outputs), memory }
}

/// Linear functions of a table; the weights of each have their bias at a place among them.
fn affine(graph: &mut OnnxGraph, table: &Value, weights: &[f64], columns: usize, bias: usize) -> Value {
    let row = columns + 1;
    let plain = without(weights, row, bias);
    let biases: Vec<f64> = weights.chunks_exact(row).map(|weights| weights[bias]).collect();
    graph.linear(table, columns, &transposed(&plain, columns), Some(&biases))
}

/// Rows without one of their columns.
fn without(rows: &[f64], width: usize, column: usize) -> Vec<f64> {
    let others = |row: &[f64]| [&row[..column], &row[column + 1..]].concat();
    rows.chunks_exact(width).flat_map(others).collect()
}

fn transposed(rows: &[f64], width: usize) -> Vec<f64> {
    (0..width).flat_map(|column| rows.chunks_exact(width).map(move |row| row[column])).collect()
}
