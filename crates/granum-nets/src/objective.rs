//! The error of a model over the rows of a table, and its gradient, for user-defined trainers.

use granum_simd::Isa;

use crate::differentiable::check_columns;
use crate::differentiable::{Batch, Differentiable};
use crate::table::data::Data;
use crate::training_error::TrainingError;

/// The mean squared error of a model as a function of its weights,
///
/// ```text
/// E = sum of w (prediction - target)^2 / (observations * targets)
/// ```
///
/// with the weights `w` of the rows. Sums have a fixed order, so that the bits are identical with every instruction set.
///
/// ```
/// use granum_nets::{Data, Network, Objective};
///
/// let data = Data::new(vec![0.0, 0.5, 1.0], 1, vec![0.2, 0.4, 0.8])?;
/// let network = Network::new(&[1, 3, 1], 1)?;
/// let mut objective = Objective::new(&network, &data)?;
/// let (error, gradient) = objective.error_and_gradient(network.weights())?;
/// // A small step against the gradient lowers the error.
/// let lower: Vec<f64> = network.weights().iter().zip(&gradient).map(|(w, g)| w - 0.01 * g).collect();
/// assert!(objective.error(&lower)? < error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Objective {
    batch: Box<dyn Batch>,
    /// Number of errors: observations times targets.
    values: f64,
    weights: usize,
}

impl Objective {
    /// The error over the given rows, or sequences of rows, for models with the shape of `model`.
    ///
    /// # Errors
    /// If the data do not match the model.
    pub fn new(model: &dyn Differentiable, data: &Data) -> Result<Objective, TrainingError> {
        check_columns(model, data)?;
        Ok(Objective {
            batch: model.batch(Isa::detect(), data)?,
            values: data.observations() * data.target_columns() as f64,
            weights: model.weights().len(),
        })
    }

    /// The mean squared error at the given weights.
    ///
    /// # Errors
    /// If the number of weights is not that of the model.
    pub fn error(&mut self, weights: &[f64]) -> Result<f64, TrainingError> {
        if weights.len() != self.weights {
            return Err(TrainingError::Weights { expected: self.weights, found: weights.len() });
        }
        Ok(self.batch.squared_error(weights) / self.values)
    }

    /// The mean squared error at the given weights, and its derivatives with respect to the weights.
    ///
    /// # Errors
    /// As [`Objective::error`].
    pub fn error_and_gradient(&mut self, weights: &[f64]) -> Result<(f64, Vec<f64>), TrainingError> {
        let error = self.error(weights)?;
        let mut gradient = vec![0.0; weights.len()];
        self.batch.gradient(weights, 2.0 / self.values, &mut gradient);
        Ok((error, gradient))
    }
}
