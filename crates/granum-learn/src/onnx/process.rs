//! Gaussian processes as graphs: the covariances of a row with the training rows, and from them mean and variance.

use granum_nets::gaussian_process::{GaussianProcess, ProcessParts, Rows};

use super::graph::{OnnxGraph, Value};

/// Rows of a triangular matrix that are multiplied together; what is zero beyond them is left out.
const BLOCK: usize = 128;

/// The rows of a table as processes see them that share their training rows.
pub struct ProcessRows {
    rows: Value,
    count: usize,
    columns: usize,
    /// The training rows, a column each.
    known: Value,
    /// The square of each difference: row, training row, input.
    squares: Value,
}

impl ProcessRows {
    /// For a table with a column for each input of the processes.
    pub fn new(graph: &mut OnnxGraph, rows: &Value, known: &Rows) -> ProcessRows {
        let (count, columns) = (known.count(), known.columns());
        let each = graph.shaped(rows, &[-1, 1, columns as i64]);
        let others = graph.constant(&[1, count, columns], known.values());
        let apart = graph.apply("Sub", &[&each, &others]);
        let squares = graph.apply("Mul", &[&apart, &apart]);
        let known = super::unit::transposed(known.values(), columns);
        let known = graph.constant(&[columns, count], &known);
        ProcessRows { rows: rows.clone(), count, columns, known, squares }
    }

    /// The covariances of each row with all training rows, and with itself (a column).
    fn covariances(&self, graph: &mut OnnxGraph, parts: &ProcessParts) -> [Value; 2] {
        let narrowness = graph.constant(&[1, 1, self.columns], parts.narrowness);
        let powers = graph.apply("Mul", &[&self.squares, &narrowness]);
        let weights = graph.constant(&[1, 1, self.columns], parts.weights);
        let exponents = graph.apply("Neg", &[&powers]);
        let functions = graph.apply("Exp", &[&exponents]);
        let functions = graph.apply("Mul", &[&functions, &weights]);
        let axis = graph.integers(&[2]);
        let total = |graph: &mut OnnxGraph, table: &Value| {
            graph.apply_with("ReduceSum", &[table, &axis], &[("keepdims", 0)])
        };
        let sum = total(graph, &functions);
        let squares = graph.apply("Mul", &[&functions, &functions]);
        let squares = total(graph, &squares);
        let exponent = total(graph, &exponents);
        let product = graph.apply("Exp", &[&exponent]);
        let slopes = graph.row(parts.slopes);
        let sloped = graph.apply("Mul", &[&self.rows, &slopes]);
        let line = graph.apply("MatMul", &[&sloped, &self.known]);
        let [half_pairs, weight, constant] =
            [0.5 * parts.pairs, parts.product, parts.constant].map(|value| graph.number(value));
        let square_of_sum = graph.apply("Mul", &[&sum, &sum]);
        let pairs = graph.apply("Sub", &[&square_of_sum, &squares]);
        let pairs = graph.apply("Mul", &[&pairs, &half_pairs]);
        let product = graph.apply("Mul", &[&product, &weight]);
        let with = [&sum, &pairs, &product, &constant]
            .into_iter()
            .fold(line, |all, part| graph.apply("Add", &[&all, part]));
        let sum: f64 = parts.weights.iter().sum();
        let squares: f64 = parts.weights.iter().map(|weight| weight * weight).sum();
        let own = sum + 0.5 * parts.pairs * (sum * sum - squares) + parts.product + parts.constant;
        let own = graph.number(own);
        let line = graph.apply("Mul", &[&sloped, &self.rows]);
        let line = graph.sum_of_rows(&line);
        [with, graph.apply("Add", &[&line, &own])]
    }
}

/// The mean of a process for each row and its variance, which more rows would reduce: a column each.
pub struct OnnxProcess {
    pub mean: Value,
    pub variance: Value,
}

/// A process for rows.
pub fn process(graph: &mut OnnxGraph, rows: &ProcessRows, process: &GaussianProcess) -> OnnxProcess {
    let parts = process.parts();
    let [with, own] = rows.covariances(graph, &parts);
    let [centre, deviation] = parts.scale;
    let solved: Vec<f64> = parts.solved.iter().take(rows.count).map(|value| deviation * value).collect();
    let mean = graph.linear(&with, rows.count, &solved, Some(&[centre]));
    let factor = process.inverse_factor();
    let mut known: Option<Value> = None;
    for first in (0..rows.count).step_by(BLOCK) {
        let end = (first + BLOCK).min(rows.count);
        // The rows of the block, a column each, up to the last one's diagonal.
        let block: Vec<f64> = (0..end)
            .flat_map(|k| (first..end).map(move |row| (row, k)))
            .map(|(row, k)| factor[row * rows.count + k])
            .collect();
        let seen = match end == rows.count {
            true => with.clone(),
            false => graph.columns(&with, &(0..end).collect::<Vec<_>>()),
        };
        let products = graph.linear(&seen, end, &block, None);
        let squares = graph.apply("Mul", &[&products, &products]);
        let squares = graph.sum_of_rows(&squares);
        known = Some(match known {
            Some(known) => graph.apply("Add", &[&known, &squares]),
            None => squares,
        });
    }
    let [zero, square] = [0.0, deviation * deviation].map(|value| graph.number(value));
    let left = match known {
        Some(known) => graph.apply("Sub", &[&own, &known]),
        None => own,
    };
    let left = graph.apply("Max", &[&left, &zero]);
    OnnxProcess { mean, variance: graph.apply("Mul", &[&left, &square]) }
}
