//! The rotations of the axes in a graph: tables have a row for each rotation of each row, one after the other.

use super::channels::Widths;
use super::rotation::{COMPONENTS, Rotation};
use crate::onnx::{OnnxGraph, Value, part};

/// The rotations over which predictions are means; `None` leaves the axes as they are.
pub(super) struct OnnxRotations<'a> {
    rotations: &'a [Option<Rotation>],
    widths: Widths,
}

impl OnnxRotations<'_> {
    pub fn new(rotations: &[Option<Rotation>], widths: Widths) -> OnnxRotations<'_> {
        OnnxRotations { rotations, widths }
    }

    /// Number of rotations.
    pub fn count(&self) -> usize {
        self.rotations.len()
    }

    fn is_plain(&self) -> bool {
        matches!(self.rotations, [None])
    }

    /// Factors of components, row by row: where `matrix[i][r k + j]` is that of component i for component j of the turned tensor of rotation r, of which there are k.
    fn factors(&self) -> Vec<f64> {
        let unturned: [[f64; COMPONENTS]; COMPONENTS] =
            std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        let rows = |rotation: &Option<Rotation>| rotation.as_ref().map_or(unturned, |own| *own.rows());
        let all: Vec<_> = self.rotations.iter().map(rows).collect();
        (0..COMPONENTS)
            .flat_map(|i| all.iter().flat_map(move |own| (0..COMPONENTS).map(move |j| own[j][i])))
            .collect()
    }

    /// The same rows for each rotation.
    pub fn repeated(&self, graph: &mut OnnxGraph, table: &Value, columns: usize) -> Value {
        if self.is_plain() {
            return table.clone();
        }
        let (count, columns) = (self.count(), columns as i64);
        let rows = graph.shaped(table, &[-1, 1, columns]);
        let ones = graph.constant(&[1, count, 1], &vec![1.0; count]);
        let repeated = graph.apply("Mul", &[&rows, &ones]);
        graph.shaped(&repeated, &[-1, columns])
    }

    /// Rows of so many deviators, the first component of each first, then the second of each and so on, turned by each rotation.
    fn turned(&self, graph: &mut OnnxGraph, table: &Value, tensors: usize) -> Value {
        let (rotations, components, tensors) = (self.count() as i64, COMPONENTS as i64, tensors as i64);
        let rows = graph.shaped(table, &[-1, components, tensors]);
        let rows = graph.transposed(&rows, &[0, 2, 1]);
        let turned = graph.linear(&rows, COMPONENTS, &self.factors(), None);
        let turned = graph.shaped(&turned, &[-1, tensors, rotations, components]);
        let turned = graph.transposed(&turned, &[0, 2, 3, 1]);
        graph.shaped(&turned, &[-1, components * tensors])
    }

    /// The directions of increments, so many one after the other in each row, turned by each rotation.
    pub fn directions(&self, graph: &mut OnnxGraph, table: &Value, increments: usize) -> Value {
        let Widths { direction, further, .. } = self.widths;
        if self.is_plain() {
            return table.clone();
        }
        let width = direction + further;
        // A row for each increment, of which the direction is turned alone.
        let rows = graph.shaped(table, &[-1, width as i64]);
        let own = part(graph, &rows, 0, direction).map(|own| self.turned(graph, &own, 1));
        let others =
            part(graph, &rows, direction, further).map(|others| self.repeated(graph, &others, further));
        let rows = graph.beside(&own.iter().chain(&others).collect::<Vec<_>>());
        let (increments, rotations, width) = (increments as i64, self.count() as i64, width as i64);
        let rows = graph.shaped(&rows, &[-1, increments, rotations, width]);
        let rows = graph.transposed(&rows, &[0, 2, 1, 3]);
        graph.shaped(&rows, &[-1, increments * width])
    }

    /// Start values turned by each rotation.
    pub fn starts(&self, graph: &mut OnnxGraph, table: &Value) -> Value {
        let Widths { tensors, start_scalars, .. } = self.widths;
        if self.is_plain() {
            return table.clone();
        }
        let components = COMPONENTS * tensors;
        let own = part(graph, table, 0, components).map(|own| self.turned(graph, &own, tensors));
        let scalars = part(graph, table, components, start_scalars)
            .map(|scalars| self.repeated(graph, &scalars, start_scalars));
        graph.beside(&own.iter().chain(&scalars).collect::<Vec<_>>())
    }

    /// The mean of the outputs of all rotations, each turned back.
    pub fn mean(&self, graph: &mut OnnxGraph, outputs: &Value) -> Value {
        let Widths { tensors, scalars, .. } = self.widths;
        if self.is_plain() {
            return outputs.clone();
        }
        let (rotations, components) = (self.count(), COMPONENTS * tensors);
        let share = 1.0 / rotations as f64;
        let own = part(graph, outputs, 0, components).map(|own| {
            let tensors = tensors as i64;
            let rows = graph.shaped(&own, &[-1, (COMPONENTS * rotations) as i64, tensors]);
            // A rotation is undone by its transposed factors.
            let back: Vec<f64> = self.factors().iter().map(|factor| share * factor).collect();
            let back = graph.constant(&[COMPONENTS, COMPONENTS * rotations], &back);
            let mean = graph.apply("MatMul", &[&back, &rows]);
            graph.shaped(&mean, &[-1, components as i64])
        });
        let scalars = part(graph, outputs, components, scalars).map(|own| {
            let rows = graph.shaped(&own, &[-1, rotations as i64, scalars as i64]);
            let axis = graph.integers(&[1]);
            let sums = graph.apply_with("ReduceSum", &[&rows, &axis], &[("keepdims", 0)]);
            let share = graph.number(share);
            graph.apply("Mul", &[&sums, &share])
        });
        graph.beside(&own.iter().chain(&scalars).collect::<Vec<_>>())
    }
}
