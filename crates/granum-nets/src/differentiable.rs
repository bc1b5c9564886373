//! What trainers see of a model: its weights, and the error with its gradient over a batch of rows or of sequences.

use granum_simd::Isa;

use crate::sequence::stepper::Stepper;
use crate::table::data::Data;
use crate::table::sequences::Sequences;
use crate::training_error::TrainingError;

/// A model with weights that can be trained: a feed-forward network, a recurrent cell, or a model of your own.
///
/// A trainer holds a [`Batch`] of rows, which gives the error and its gradient at any weights. Trainers of Gauss-Newton kind
/// need [`Differentiable::gauss_newton`] as well, which a model may leave out.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver, Trainer, TrainingError};
/// use granum_nets::{Batch, Data, Differentiable, Isa, Sequences};
///
/// /// A straight line through the origin: `y = w x`.
/// struct Slope([f64; 1]);
///
/// struct Rows(Data);
///
/// impl Batch for Rows {
///     fn squared_error(&mut self, weights: &[f64]) -> f64 {
///         self.0.inputs().iter().zip(self.0.targets()).map(|(x, y)| (weights[0] * x - y).powi(2)).sum()
///     }
///     fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]) {
///         let slope = |(x, y): (&f64, &f64)| scale * (weights[0] * x - y) * x;
///         gradient[0] = self.0.inputs().iter().zip(self.0.targets()).map(slope).sum();
///     }
/// }
///
/// impl Differentiable for Slope {
///     fn name(&self) -> &str {
///         "slope"
///     }
///     fn inputs(&self) -> usize {
///         1
///     }
///     fn outputs(&self) -> usize {
///         1
///     }
///     fn weights(&self) -> &[f64] {
///         &self.0
///     }
///     fn weights_mut(&mut self) -> &mut [f64] {
///         &mut self.0
///     }
///     fn evaluate(&self, _: Isa, inputs: &[f64], _: Option<&Sequences>) -> Result<Vec<f64>, TrainingError> {
///         Ok(inputs.iter().map(|x| self.0[0] * x).collect())
///     }
///     fn batch(&self, _: Isa, data: &Data) -> Result<Box<dyn Batch>, TrainingError> {
///         Ok(Box::new(Rows(data.clone())))
///     }
/// }
///
/// let data = Data::new(vec![0.5, 1.0, 2.0], 1, vec![1.0, 2.0, 4.0])?;
/// let mut slope = Slope([0.1]);
/// Adam { learning_rate: 0.05, ..Adam::default() }.train(&mut slope, &data, &mut NoObserver)?;
/// assert!((slope.0[0] - 2.0).abs() < 1e-3, "{}", slope.0[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Differentiable: Send + Sync {
    /// The kind of model, for messages.
    fn name(&self) -> &str;

    /// Number of input columns.
    fn inputs(&self) -> usize;

    /// Number of output columns.
    fn outputs(&self) -> usize;

    /// All weights in a fixed order.
    fn weights(&self) -> &[f64];

    /// The weights, which can be changed in place.
    fn weights_mut(&mut self) -> &mut [f64];

    /// The outputs, `rows x outputs`, for rows of inputs, `rows x inputs`, both in row-major order. A model with memory needs
    /// the division of the rows into sequences; a model without memory ignores it.
    ///
    /// # Errors
    /// If the rows do not match the model.
    fn evaluate(
        &self,
        isa: Isa,
        inputs: &[f64],
        sequences: Option<&Sequences>,
    ) -> Result<Vec<f64>, TrainingError>;

    /// As many sequences, each with its start values, whose rows come one after the other: a model with memory keeps its state between
    /// them. The outputs have the bits of [`Differentiable::evaluate`] for the rows together.
    ///
    /// # Errors
    /// If the start values do not match the model, or it has no memory that could be kept.
    fn stepper(&self, isa: Isa, sequences: usize, starts: &[f64]) -> Result<Box<dyn Stepper>, TrainingError> {
        let _ = (isa, sequences, starts);
        let name = self.name();
        Err(TrainingError::Rows(format!("a {name} has no state that could be kept from row to row")))
    }

    /// The rows of a table in the form for training. Results do not depend on the instruction set.
    ///
    /// # Errors
    /// If the rows do not match the model, or the memory does not suffice.
    fn batch(&self, isa: Isa, data: &Data) -> Result<Box<dyn Batch>, TrainingError>;

    /// The rows of a table with their Gauss-Newton matrix; `None` if the model does not provide it.
    ///
    /// # Errors
    /// As [`Differentiable::batch`].
    fn gauss_newton(&self, isa: Isa, data: &Data) -> Result<Option<Box<dyn GaussNewton>>, TrainingError> {
        let _ = (isa, data);
        Ok(None)
    }
}

/// The error of a model over the rows of a table as a function of the weights. Sums have a fixed order.
pub trait Batch: Send {
    /// The weighted sum of squared errors, over all rows and outputs.
    fn squared_error(&mut self, weights: &[f64]) -> f64;

    /// The gradient of `scale / 2` times that sum, after [`Batch::squared_error`] with the same weights.
    fn gradient(&mut self, weights: &[f64], scale: f64, gradient: &mut [f64]);
}

/// A batch that also has the Jacobian `J` of its weighted residuals `e`, and solves the equations of regularised Gauss-Newton
/// steps with it, in the form that suits the model.
pub trait GaussNewton: Batch {
    /// Computes residuals and Jacobian at the weights of the last [`Batch::squared_error`]; returns false if they are not
    /// finite.
    fn linearise(&mut self, weights: &[f64]) -> bool;

    /// `J^T e`, half of the gradient of the sum of squared errors.
    fn projected_residuals(&mut self, product: &mut [f64]);

    /// Factorises `J^T J + shift I`; returns false if it is not positive definite to working precision.
    fn factorise(&mut self, shift: f64) -> bool;

    /// Effective number of parameters for the shift of the last factorisation: the sum over the eigenvalues of `J^T J` of
    /// `lambda / (lambda + shift)`.
    fn effective_parameters(&mut self, shift: f64) -> f64;

    /// `-(J^T J + shift I)^-1 (J^T e + decay w)` for the shift of the last factorisation, `decay <= shift`.
    fn step(&mut self, weights: &[f64], decay: f64, shift: f64, step: &mut [f64]);

    /// The residuals that the observations of each block would have, to first order, if the model had not been trained on
    /// the block, for the shift of the last factorisation. `blocks` has the number of the block of each observation.
    fn left_out_residuals(&self, blocks: &[usize], shift: f64) -> Option<Vec<f64>>;
}

/// Refuses data whose numbers of columns do not match the model.
pub(crate) fn check_columns(model: &dyn Differentiable, data: &Data) -> Result<(), TrainingError> {
    if (model.inputs(), model.outputs()) == (data.input_columns(), data.target_columns()) {
        return Ok(());
    }
    Err(TrainingError::Columns {
        inputs: model.inputs(),
        outputs: model.outputs(),
        columns: data.input_columns(),
        targets: data.target_columns(),
    })
}
