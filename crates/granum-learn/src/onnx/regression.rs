//! Rows of ridge regression as graphs.

use super::graph::{OnnxGraph, Value};
use crate::regression::spline::{FUNCTIONS, INTERVALS};

/// The cubic B-splines of a coordinate, of which the start and the length are given, a column each: with the place `p` between knots and `d` the distance from the middle of
/// a spline, `((2 - d)^3 - 4 (1 - d)^3) / 6`, where negative differences count as zero.
pub fn along(graph: &mut OnnxGraph, inputs: &Value, input: usize, [start, length]: [f64; 2]) -> Value {
    let column = graph.columns(inputs, &[input]);
    let per_length = if length > 0.0 { 1.0 / length } else { 0.0 };
    let share = graph.scaled(&column, &[start], &[per_length], &[0.0]);
    let [zero, one, two, four, sixth] = [0.0, 1.0, 2.0, 4.0, 1.0 / 6.0].map(|value| graph.number(value));
    let share = graph.apply("Max", &[&share, &zero]);
    let share = graph.apply("Min", &[&share, &one]);
    let root = graph.apply("Sqrt", &[&share]);
    let intervals = graph.number(INTERVALS as f64);
    let place = graph.apply("Mul", &[&root, &intervals]);
    let middles: Vec<f64> = (0..FUNCTIONS).map(|k| k as f64 - 1.0).collect();
    let middles = graph.row(&middles);
    let distance = graph.apply("Sub", &[&place, &middles]);
    let distance = graph.apply("Abs", &[&distance]);
    let cube = |graph: &mut OnnxGraph, from: &Value| {
        let rest = graph.apply("Sub", &[from, &distance]);
        let rest = graph.apply("Max", &[&rest, &zero]);
        let square = graph.apply("Mul", &[&rest, &rest]);
        graph.apply("Mul", &[&square, &rest])
    };
    let (outer, inner) = (cube(graph, &two), cube(graph, &one));
    let inner = graph.apply("Mul", &[&inner, &four]);
    let difference = graph.apply("Sub", &[&outer, &inner]);
    graph.apply("Mul", &[&difference, &sixth])
}

/// The row of a regression for each row of inputs: functions of the coordinate, and scaled deviations of the other inputs.
pub struct RidgeRow {
    row: Value,
    size: usize,
}

impl RidgeRow {
    /// Of the functions of the coordinate, which are the number one without one, and the columns of the other inputs, each with the coefficients of its mean
    /// along the coordinate and its standard deviation from there.
    pub fn new(
        graph: &mut OnnxGraph,
        inputs: &Value,
        functions: Option<Value>,
        others: &[usize],
        deviations: &[(&[f64], f64)],
    ) -> RidgeRow {
        let (functions, count) = match functions {
            Some(functions) => (functions, FUNCTIONS),
            None => {
                // A column of ones, as long as the inputs.
                let (zero, one) = (graph.number(0.0), graph.number(1.0));
                let column = graph.columns(inputs, &[0]);
                let zeros = graph.apply("Mul", &[&column, &zero]);
                (graph.apply("Add", &[&zeros, &one]), 1)
            }
        };
        let size = count + others.len();
        if others.is_empty() {
            return RidgeRow { row: functions, size };
        }
        let own = graph.columns(inputs, others);
        let means: Vec<f64> =
            (0..count).flat_map(|k| deviations.iter().map(move |(mean, _)| mean[k])).collect();
        let means = graph.linear(&functions, count, &means, None);
        let apart = graph.apply("Sub", &[&own, &means]);
        let scale = |(_, deviation): &(&[f64], f64)| if *deviation > 0.0 { 1.0 / deviation } else { 0.0 };
        let scales = graph.row(&deviations.iter().map(scale).collect::<Vec<_>>());
        let scaled = graph.apply("Mul", &[&apart, &scales]);
        RidgeRow { row: graph.beside(&[&functions, &scaled]), size }
    }

    /// The product of the row and a matrix of so many columns.
    pub fn product(&self, graph: &mut OnnxGraph, matrix: &[f64], columns: usize) -> Value {
        debug_assert_eq!(matrix.len(), self.size * columns);
        graph.linear(&self.row, self.size, matrix, None)
    }

    /// `row (L L^T)^-1 row^T` with a lower triangular matrix L.
    pub fn leverage(&self, graph: &mut OnnxGraph, lower: &[f64]) -> Value {
        let size = self.size;
        // The transposed inverse of L, column by column by forward substitution.
        let mut inverse = vec![0.0; size * size];
        for column in 0..size {
            for row in column..size {
                let unit = f64::from(u8::from(row == column));
                let known: f64 =
                    (column..row).map(|k| lower[row * size + k] * inverse[column * size + k]).sum();
                inverse[column * size + row] = (unit - known) / lower[row * size + row];
            }
        }
        let solved = self.product(graph, &inverse, size);
        let squares = graph.apply("Mul", &[&solved, &solved]);
        graph.sum_of_rows(&squares)
    }
}
