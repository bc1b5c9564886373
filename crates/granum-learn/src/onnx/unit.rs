//! Networks with a state as graphs: what every kind of them gives.

use super::graph::{OnnxGraph, Value};

/// The outputs of a network for a row, and its state after it.
pub struct OnnxStep {
    /// The outputs in the units of the network.
    pub outputs: Value,
    /// The state after the row.
    pub state: Value,
}

/// A network with a state as a graph.
pub trait OnnxUnit {
    /// Number of values of the state.
    fn state_values(&self) -> usize;

    /// The state before the first row from the start values of the sequence.
    fn first_state(&self, graph: &mut OnnxGraph, starts: &Value) -> Value;

    /// A row of inputs in the units of the network, after a state.
    fn advance(&self, graph: &mut OnnxGraph, inputs: &Value, state: &Value) -> OnnxStep;
}

/// Linear functions of a table; the weights of each have their bias at a place among them.
pub fn affine(graph: &mut OnnxGraph, table: &Value, weights: &[f64], columns: usize, bias: usize) -> Value {
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

/// The columns of rows of a width, one after the other.
pub fn transposed(rows: &[f64], width: usize) -> Vec<f64> {
    (0..width).flat_map(|column| rows.chunks_exact(width).map(move |row| row[column])).collect()
}

/// So many successive columns, if there is any.
pub fn part(graph: &mut OnnxGraph, table: &Value, first: usize, width: usize) -> Option<Value> {
    (width > 0).then(|| graph.columns(table, &(first..first + width).collect::<Vec<_>>()))
}

/// Successive parts of so many columns each, of which there is at least one.
pub fn parts<const COUNT: usize>(
    graph: &mut OnnxGraph,
    table: &Value,
    widths: [usize; COUNT],
) -> [Value; COUNT] {
    let mut first = 0;
    widths.map(|width| {
        let columns: Vec<usize> = (first..first + width).collect();
        first += width;
        graph.columns(table, &columns)
    })
}
