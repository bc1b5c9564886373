//! Predictions of a trained model: values, standard deviations by cause, and inputs outside the trained range.

use granum_simd::{Isa, Real, ScalarKernel, fused};

use crate::feed_forward::forward::{self, Scalers};
use crate::model::model_error::ModelError;
use crate::model::trained::Model;
use crate::model::uncertainty::{Laplace, Uncertainty};

/// A prediction for one row.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkPrediction {
    /// The value, in the unit of the output.
    pub value: f64,
    /// Standard deviation of an observation around the value (noise and uncertainty of the weights), if the model provides
    /// it.
    pub standard_deviation: Option<f64>,
    /// Names of the inputs that lie outside the trained range of the model.
    pub outside: Vec<String>,
}

/// Standard deviation of an observation around a prediction, split by its cause, in the unit of the output: the squares of
/// the causes add up to that of the total.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Deviation {
    /// The total standard deviation.
    pub total: f64,
    /// Noise of the targets.
    pub noise: f64,
    /// Uncertainty of the weights, which the training rows do not determine exactly.
    pub weights: f64,
    /// Difference of a new block (a new run) from the training blocks; 0 for a single training block, or if the errors of
    /// left-out blocks are explained by the other two causes.
    pub blocks: f64,
}

impl Deviation {
    /// Splits the variance of the Laplace approximation, given its noise part, both in scaled units, and the factor on the
    /// standard deviation from left-out blocks.
    pub(crate) fn new(variance: f64, noise: f64, factor: f64, unit: f64) -> Deviation {
        let noise = noise.min(variance);
        let within = factor.min(1.0) * unit;
        let beyond = if variance.is_finite() { (factor * factor - 1.0).max(0.0) * variance } else { 0.0 };
        Deviation {
            total: factor * variance.sqrt() * unit,
            noise: within * noise.sqrt(),
            weights: within * (variance - noise).sqrt(),
            blocks: beyond.sqrt() * unit,
        }
    }
}

/// Predictions for many rows.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchPrediction {
    /// One value per row, in the unit of the output.
    pub values: Vec<f64>,
    /// True for each row with an input outside the trained range of the model.
    pub outside: Vec<bool>,
}

impl Model {
    /// Prediction for one row, with its standard deviation and the inputs outside the trained range.
    ///
    /// # Errors
    /// If the row has the wrong length or a value is not finite.
    pub fn predict(&self, row: &[f64]) -> Result<NetworkPrediction, ModelError> {
        let value = self.value(row)?;
        let standard_deviation = self.standard_deviations(row)?.map(|d| d[0]);
        Ok(NetworkPrediction { value, standard_deviation, outside: self.outside(row) })
    }

    /// The predicted value for one row without further information, e.g. for a control loop.
    ///
    /// # Errors
    /// As [`Model::predict`].
    pub fn value(&self, row: &[f64]) -> Result<f64, ModelError> {
        if row.len() != self.inputs.len() {
            return Err(self.row_length(row.len()));
        }
        self.check_finite(row)?;
        let mut scaled = [0.0];
        self.rows.evaluate(Isa::detect(), |i| self.input_scalers[i].scale(row[i]), &mut scaled);
        Ok(self.output_scaler.unscale(scaled[0]))
    }

    /// Names of the inputs of a row that lie outside the trained range of the model.
    pub fn outside(&self, row: &[f64]) -> Vec<String> {
        let columns = self.inputs.iter().zip(&self.input_scalers).zip(row);
        columns.filter(|((_, s), v)| s.is_outside(**v)).map(|((c, _), _)| c.name.clone()).collect()
    }

    /// Predictions for many rows (a flat array in row-major order).
    ///
    /// # Errors
    /// If `rows` does not contain a whole number of rows, or a value is not finite.
    pub fn predict_batch(&self, rows: &[f64]) -> Result<BatchPrediction, ModelError> {
        self.check_rows(rows)?;
        let mut values = vec![0.0; rows.len() / self.inputs.len()];
        self.values_of(rows, &mut values);
        Ok(BatchPrediction { values, outside: self.outside_of(rows) })
    }

    /// The values of rows that have been checked.
    pub(crate) fn values_of(&self, rows: &[f64], values: &mut [f64]) {
        let scalers =
            Scalers { inputs: &self.input_scalers, outputs: std::slice::from_ref(&self.output_scaler) };
        forward::batch(Isa::detect(), &self.network, Some(scalers), rows, values);
    }

    /// Which of the rows have an input outside the trained range.
    pub(crate) fn outside_of(&self, rows: &[f64]) -> Vec<bool> {
        let is_outside = |row: &[f64]| row.iter().zip(&self.input_scalers).any(|(v, s)| s.is_outside(*v));
        rows.chunks_exact(self.inputs.len()).map(is_outside).collect()
    }

    /// Standard deviations of observations around the predictions for many rows (a flat array in row-major order), in the
    /// unit of the output; `None` if the model was trained without Bayesian regularisation. If it was trained on several
    /// blocks (runs), they are multiplied by the factors of `Intervals`, which are estimated from the errors of left-out
    /// blocks.
    ///
    /// The first call factorises the curvature over the training rows, and later calls reuse it.
    ///
    /// # Errors
    /// As [`Model::predict_batch`].
    pub fn standard_deviations(&self, rows: &[f64]) -> Result<Option<Vec<f64>>, ModelError> {
        self.standard_deviations_of(rows, 1)
    }

    /// As [`Model::standard_deviations`], for observations that consist of so many consecutive rows, see
    /// `Data::with_points`; returns one number per observation.
    ///
    /// # Errors
    /// As [`Model::predict_batch`], and if `rows` does not contain a whole number of observations.
    pub fn standard_deviations_of(
        &self,
        rows: &[f64],
        points: usize,
    ) -> Result<Option<Vec<f64>>, ModelError> {
        let deviations = self.deviations_of(rows, points)?;
        Ok(deviations.map(|all| all.iter().map(|deviation| deviation.total).collect()))
    }

    /// As [`Model::standard_deviations_of`], split by cause.
    ///
    /// # Errors
    /// As [`Model::standard_deviations_of`].
    pub fn deviations_of(&self, rows: &[f64], points: usize) -> Result<Option<Vec<Deviation>>, ModelError> {
        self.check_observations(rows, points)?;
        Ok(self.values_and_deviations(rows, points).map(|(_, deviations)| deviations))
    }

    /// [`Model::predict_batch`] and [`Model::deviations_of`] for the same rows, to the bit, in less time than one after the other.
    ///
    /// # Errors
    /// As [`Model::standard_deviations_of`].
    pub fn predict_batch_with_deviations(
        &self,
        rows: &[f64],
        points: usize,
    ) -> Result<(BatchPrediction, Option<Vec<Deviation>>), ModelError> {
        self.check_observations(rows, points)?;
        let Some((values, deviations)) = self.values_and_deviations(rows, points) else {
            return Ok((self.predict_batch(rows)?, None));
        };
        Ok((BatchPrediction { values, outside: self.outside_of(rows) }, Some(deviations)))
    }

    /// The uncertainty of the weights in numbers; `None` if the model was trained without Bayesian regularisation.
    pub fn uncertainty(&self) -> Option<Uncertainty> {
        self.laplace().map(|laplace| laplace.numbers(self.network.weights().len()))
    }

    fn laplace(&self) -> Option<&Laplace> {
        let laplace = self.laplace.get_or_init(|| {
            let (rows, evidence) = (self.training_rows.as_ref()?, self.fit.evidence?);
            Laplace::new(Isa::detect(), &self.network, rows, evidence)
        });
        laplace.as_ref()
    }

    /// Values of rows that have been checked, and deviations of their observations; `None` if there are no deviations.
    fn values_and_deviations(&self, rows: &[f64], points: usize) -> Option<(Vec<f64>, Vec<Deviation>)> {
        let laplace = self.laplace()?;
        let (mut values, variances) = laplace.outputs_and_variances(&self.network, self.scaled(rows), points);
        let output = &self.output_scaler;
        fused(Scaled(&mut values, &[(output.offset(), output.inverse_factor(), output.minimum)]));
        let columns = self.inputs.len();
        for (row, value) in rows.chunks_exact(columns).zip(&mut values).filter(|(_, value)| value.is_nan()) {
            self.values_of(row, std::slice::from_mut(value));
        }
        let (unit, noise) = (self.output_scaler.inverse_factor(), laplace.noise());
        let factors = self.factors(rows, points);
        let each = variances.iter().zip(&factors);
        let deviations =
            each.map(|(variance, factor)| Deviation::new(*variance, noise, *factor, unit)).collect();
        Some((values, deviations))
    }

    fn scaled(&self, rows: &[f64]) -> Vec<f64> {
        // The factors of the scalers take divisions, which are done once.
        let scalers: Vec<_> =
            self.input_scalers.iter().map(|s| (s.minimum, s.factor(), s.offset())).collect();
        let mut scaled = rows.to_vec();
        fused(Scaled(&mut scaled, &scalers));
        scaled
    }

    /// The factor on the standard deviation of each observation from left-out blocks, see `Intervals`.
    pub(crate) fn factors(&self, rows: &[f64], points: usize) -> Vec<f64> {
        let observations = rows.chunks(points * self.inputs.len());
        let Some(intervals) = &self.fit.intervals else { return vec![1.0; observations.len()] };
        let column = self.inputs.iter().position(|input| Some(&input.name) == intervals.input.as_ref());
        observations.map(|row| intervals.factor(column.map_or(0.0, |column| row[column]))).collect()
    }

    /// Variance of the noise of the targets, in the square of the unit of the output; `None` if the model was trained without Bayesian
    /// regularisation.
    pub(crate) fn noise_variance(&self) -> Option<f64> {
        let unit = self.output_scaler.inverse_factor();
        self.fit.evidence.map(|evidence| unit * unit / evidence.beta)
    }

    fn row_length(&self, given: usize) -> ModelError {
        let names: Vec<&str> = self.inputs.iter().map(|c| c.name.as_str()).collect();
        ModelError::RowLength { expected: self.inputs.len(), names: names.join(", "), given }
    }

    fn check_observations(&self, rows: &[f64], points: usize) -> Result<(), ModelError> {
        self.check_rows(rows)?;
        let found = rows.len() / self.inputs.len();
        if points == 0 || !found.is_multiple_of(points) {
            return Err(ModelError::Columns(format!(
                "{found} rows are not a whole number of observations of {points} points"
            )));
        }
        Ok(())
    }

    pub(crate) fn check_rows(&self, rows: &[f64]) -> Result<(), ModelError> {
        let columns = self.inputs.len();
        if !rows.len().is_multiple_of(columns) {
            return Err(self.row_length(rows.len() % columns));
        }
        self.check_finite(rows)
    }

    fn check_finite(&self, rows: &[f64]) -> Result<(), ModelError> {
        match rows.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(i) => Err(ModelError::NotFinite {
                row: i / self.inputs.len(),
                name: self.inputs[i % self.inputs.len()].name.clone(),
                value: rows[i],
            }),
        }
    }
}

/// Maps the values of rows: `(value - shift) factor + offset`, with a shift, factor and offset for each column.
struct Scaled<'a>(&'a mut [f64], &'a [(f64, f64, f64)]);

impl ScalarKernel for Scaled<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        for row in self.0.chunks_exact_mut(self.1.len()) {
            for (value, (shift, factor, offset)) in row.iter_mut().zip(self.1) {
                let scaled = R::splat(*value - shift).mul_add(R::splat(*factor), R::splat(*offset));
                *value = scaled.reduce_add();
            }
        }
    }
}
