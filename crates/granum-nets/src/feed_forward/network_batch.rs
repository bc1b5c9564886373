//! A feed-forward network as a model that trainers see.

use granum_simd::{Isa, Row8};

use crate::differentiable::check_columns;
use crate::differentiable::{Batch, Differentiable, GaussNewton};
use crate::feed_forward::backprop::Workspace;
use crate::feed_forward::curvature::Curvature;
use crate::feed_forward::network::Network;
use crate::linear_algebra::kernels::blocks;
use crate::table::data::Data;
use crate::table::sequences::Sequences;
use crate::training_error::TrainingError;

/// Limit on the memory for the Gauss-Newton matrix, bytes.
const MEMORY: usize = 2 << 30;

impl Differentiable for Network {
    fn name(&self) -> &str {
        "feed-forward network"
    }

    fn inputs(&self) -> usize {
        Network::inputs(self)
    }

    fn outputs(&self) -> usize {
        Network::outputs(self)
    }

    fn weights(&self) -> &[f64] {
        Network::weights(self)
    }

    fn weights_mut(&mut self) -> &mut [f64] {
        Network::weights_mut(self)
    }

    fn evaluate(&self, isa: Isa, inputs: &[f64], _: Option<&Sequences>) -> Result<Vec<f64>, TrainingError> {
        self.forward_on(isa, inputs).map_err(|error| TrainingError::Rows(error.to_string()))
    }

    fn batch(&self, isa: Isa, data: &Data) -> Result<Box<dyn Batch>, TrainingError> {
        check_columns(self, data)?;
        Ok(Box::new(Workspace::new(isa, self, data)))
    }

    fn gauss_newton(&self, isa: Isa, data: &Data) -> Result<Option<Box<dyn GaussNewton>>, TrainingError> {
        check_columns(self, data)?;
        let (rows, weights) = (data.rows() * data.target_columns(), self.weights().len());
        let bytes = Curvature::bytes(rows, rows / data.points(), weights)
            .saturating_add(Workspace::bytes(self, rows));
        if bytes > MEMORY {
            return Err(TrainingError::Memory { rows, weights, bytes, limit: MEMORY });
        }
        let workspace = Workspace::for_residuals(isa, self, data);
        Ok(Some(Box::new(Linearised {
            curvature: Curvature::new(&workspace, weights),
            residuals: vec![Row8::default(); blocks(workspace.observations())],
            workspace,
        })))
    }
}

impl Batch for Workspace {
    fn squared_error(&mut self, weights: &[f64]) -> f64 {
        Workspace::squared_error(self, weights)
    }

    fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]) {
        Workspace::gradient(self, weights, scale, gradient);
    }
}

/// The rows of a network with their residuals and their Gauss-Newton matrix in kernel form.
struct Linearised {
    workspace: Workspace,
    curvature: Curvature,
    /// The weighted residuals at the weights of the last linearisation.
    residuals: Vec<Row8>,
}

impl Batch for Linearised {
    fn squared_error(&mut self, weights: &[f64]) -> f64 {
        self.workspace.squared_error(weights)
    }

    fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]) {
        self.workspace.gradient(weights, scale, gradient);
    }
}

impl GaussNewton for Linearised {
    fn linearise(&mut self, weights: &[f64]) -> bool {
        self.workspace.sensitivities(weights);
        self.workspace.residuals(&mut self.residuals);
        self.curvature.form(&self.workspace)
    }

    fn projected_residuals(&mut self, product: &mut [f64]) {
        self.workspace.transposed_jacobian_times(&self.residuals, product);
    }

    fn factorise(&mut self, shift: f64) -> bool {
        self.curvature.factorise(shift)
    }

    fn effective_parameters(&mut self, shift: f64) -> f64 {
        self.curvature.effective_parameters(shift)
    }

    fn step(&mut self, weights: &[f64], decay: f64, shift: f64, step: &mut [f64]) {
        self.curvature.step(&self.workspace, &self.residuals, weights, decay, shift, step);
    }

    fn left_out_residuals(&self, blocks: &[usize], shift: f64) -> Option<Vec<f64>> {
        let residuals = &Row8::numbers(&self.residuals)[..blocks.len()];
        self.curvature.left_out_residuals(blocks, residuals, shift)
    }
}
