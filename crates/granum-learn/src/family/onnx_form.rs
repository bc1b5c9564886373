//! A fitted family as the graph of an ONNX file: what it answers where the values of all inputs are given.

use super::model::{FamilyModel, unfit};
use super::prediction::ROUNDING;
use crate::error::Result;
use crate::methods::onnx_curves;
use crate::onnx::{self, OnnxGraph};

impl FamilyModel {
    /// Adds what it answers to the graph of an ONNX file, with intervals of a level: an input for the coordinate and for each input of the family, all of which
    /// must be given. What the runs say of inputs that are not given (their typical values, and means over the ranges of properties) is not in the graph.
    ///
    /// # Errors
    /// If its surrogate has no ONNX form.
    pub fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        let (surrogate, curves) =
            (self.surrogate(), self.curves().ok_or_else(|| unfit("its surrogate has no curves"))?);
        let columns = surrogate.columns();
        let inputs = onnx::inputs(graph, columns);
        let (answer, unseen) = onnx_curves(curves, graph, &inputs, level)?;
        // The ranges of the family beside that of the coordinate, beyond which values are outside by more than rounding.
        let coordinate = answer.ranges.iter().take(1).copied();
        let ranges: Vec<[f64; 2]> = coordinate.chain(self.ranges()).collect();
        let wider = |[low, high]: &[f64; 2]| {
            let slight = ROUNDING * low.abs().max(high.abs());
            [low - slight, high + slight]
        };
        let mut outside = onnx::outside(graph, &inputs, &ranges.iter().map(wider).collect::<Vec<_>>());
        if let Some(unseen) = unseen {
            // An input that is outside of its own range is named already.
            let one = graph.number(1.0);
            let inside = graph.apply("Sub", &[&one, &answer.outside]);
            let unseen = graph.apply("Mul", &[&unseen, &inside]);
            outside = graph.apply("Max", &[&outside, &unseen]);
        }
        onnx::state_ranges(graph, columns, &ranges);
        let outputs = 0..columns.outputs.len();
        let possible: Vec<[f64; 2]> = outputs.map(|output| surrogate.possible_values(output)).collect();
        onnx::outputs_within(graph, columns, &answer.estimates, &outside, &possible);
        graph.state("granum.family", self.definition().name);
        graph.state("granum.path", self.definition().path);
        Ok(())
    }
}
