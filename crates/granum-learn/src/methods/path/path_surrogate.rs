//! Fitted networks with a state as a surrogate.

use std::sync::Arc;

use super::fitted::{FittedPath, Kept};
use super::onnx_form::onnx_step;
use super::steps::PathSteps;
use crate::error::Result;
use crate::onnx::OnnxGraph;
use crate::surrogate::content::Content;
use crate::surrogate::prediction::Prediction;
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::run_steps::RunSteps;
use crate::surrogate::spec::Columns;
use crate::surrogate::surrogate_trait::Surrogate;

/// Shared, so that a run can own what it needs of it.
impl Surrogate for Arc<FittedPath> {
    fn method(&self) -> &str {
        self.sizes.cell.name()
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        if inputs.is_empty() {
            return Ok(Vec::new());
        }
        let networks = self.outputs_of_networks(inputs)?;
        let path = self.channels.path(inputs);
        let known = self.errors.as_ref().map(|errors| (errors.factors(level), errors.sizes(&path.samples)));
        let known = known.as_ref().map(|(factors, sizes)| (factors.as_slice(), sizes.as_slice()));
        Ok(inputs.rows().enumerate().map(|row| self.prediction(&networks, &path, known, row)).collect())
    }

    fn steps(&self, level: f64) -> Result<Option<Box<dyn RunSteps>>> {
        Ok(Some(Box::new(PathSteps::new(Arc::clone(self), level))))
    }

    fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        onnx_step(self, graph, level);
        Ok(())
    }

    fn content(&self) -> Result<Content> {
        Content::new(&Kept {
            sizes: self.sizes,
            channels: self.channels.clone(),
            is_mean: self.is_mean,
            ranges: self.ranges.clone(),
            errors: self.errors.clone(),
            networks: self.networks.iter().map(|network| network.weights().to_vec()).collect(),
        })
    }
}
