//! The soft sensors of a cascade in the graph of an ONNX file.

use crate::onnx::{OnnxEstimate, OnnxGraph, Value};

/// What the second stage is asked: first the sensors as they are predicted, then with the first of them changed by its standard deviation, then with the second, and so on, a table below the other.
pub(super) struct OnnxSensors {
    rows: Value,
    /// Number of tables.
    tables: usize,
}

impl OnnxSensors {
    /// From the column of the coordinate and the estimates of the first stage.
    pub fn new(graph: &mut OnnxGraph, coordinate: &Value, sensors: &[OnnxEstimate]) -> OnnxSensors {
        let means = [coordinate].into_iter().chain(sensors.iter().map(|own| &own.mean)).collect::<Vec<_>>();
        let width = means.len();
        let rows = graph.beside(&means);
        let mut all = vec![rows.clone()];
        for (sensor, estimate) in sensors.iter().enumerate() {
            // Without intervals nothing is known of the error of a sensor.
            let Some([deviation, _]) = &estimate.spread else { continue };
            let place: Vec<f64> = (0..width).map(|k| f64::from(u8::from(k == sensor + 1))).collect();
            let place = graph.row(&place);
            let change = graph.apply("Mul", &[deviation, &place]);
            all.push(graph.apply("Add", &[&rows, &change]));
        }
        let tables = all.len();
        OnnxSensors { rows: graph.below(&all.iter().collect::<Vec<_>>()), tables }
    }

    /// The coordinate and the sensors of all tables.
    pub fn rows(&self) -> &Value {
        &self.rows
    }

    /// The mean of the first table, and the standard deviation with the squares of the changes of the others.
    pub fn combined(&self, graph: &mut OnnxGraph, answer: &OnnxEstimate) -> (Value, Value) {
        let tables = |graph: &mut OnnxGraph, column: &Value| graph.shaped(column, &[self.tables as i64, -1]);
        let first = |graph: &mut OnnxGraph, column: &Value| {
            let all = tables(graph, column);
            let number = graph.integers(&[0]);
            graph.apply_with("Gather", &[&all, &number], &[("axis", 0)])
        };
        let (all, mean) = (tables(graph, &answer.mean), first(graph, &answer.mean));
        let changes = graph.apply("Sub", &[&all, &mean]);
        let squares = graph.apply("Mul", &[&changes, &changes]);
        let axis = graph.integers(&[0]);
        let mut variance = graph.apply_with("ReduceSum", &[&squares, &axis], &[("keepdims", 1)]);
        if let Some([deviation, _]) = &answer.spread {
            let own = first(graph, deviation);
            let own = graph.apply("Mul", &[&own, &own]);
            variance = graph.apply("Add", &[&variance, &own]);
        }
        let deviation = graph.apply("Sqrt", &[&variance]);
        (graph.shaped(&mean, &[-1, 1]), graph.shaped(&deviation, &[-1, 1]))
    }
}
