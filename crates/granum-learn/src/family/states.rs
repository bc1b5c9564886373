//! The states of tests of a family one by one, as those of any surrogate.

use std::sync::Arc;

use super::model::FamilyModel;
use crate::error::Result;
use crate::onnx::OnnxGraph;
use crate::surrogate::{Columns, Content, Outside, Prediction, RunInputs, Surrogate};

/// A fitted family as a surrogate of states: a row has the coordinate and the values of all inputs of the family. It answers as [`FamilyModel::predict`] does where all of them are
/// given, and a state is outside where that says so.
pub struct FamilyStates(Arc<FamilyModel>);

impl FamilyStates {
    /// The states of a family.
    pub fn new(model: Arc<FamilyModel>) -> FamilyStates {
        FamilyStates(model)
    }
}

impl Surrogate for FamilyStates {
    fn method(&self) -> &str {
        self.0.surrogate().method()
    }

    fn columns(&self) -> &Columns {
        self.0.surrogate().columns()
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let coordinate = self.0.definition().coordinate;
        let judged = |(prediction, row): (Prediction, &[f64])| {
            let along = prediction.outside.iter().filter(|outside| outside.name == coordinate).cloned();
            // The coordinate comes first.
            let beside = self.0.outside(row.get(1..).unwrap_or_default());
            let outside: Vec<Outside> = along.chain(beside).collect();
            prediction.with_outside(outside)
        };
        let predictions = self.0.surrogate().evaluate(inputs, level)?;
        Ok(predictions.into_iter().zip(inputs.rows()).map(judged).collect())
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        self.0.surrogate().evaluate_means(inputs)
    }

    fn possible_values(&self, output: usize) -> [f64; 2] {
        self.0.surrogate().possible_values(output)
    }

    fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        self.0.onnx(graph, level)
    }

    /// That of its surrogate, without the ranges of the family.
    fn content(&self) -> Result<Content> {
        self.0.surrogate().content()
    }
}
