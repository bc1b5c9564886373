//! The errors of a trained model on each block of its training rows, if the block had not been used for training.

use granum_simd::Isa;

use crate::differentiable::Differentiable;
use crate::model::model_error::ModelError;
use crate::model::trained::{Model, scale};
use crate::table::data::Data;
use crate::trainer::left_out::left_out_of;

impl Model {
    /// Errors (prediction minus target, in the unit of the output) that the observations of each block (run) of the rows on which
    /// the model was trained would have, to first order, if the block had not been used for training. `None` if the model
    /// was trained without Bayesian regularisation, or there are fewer than two blocks. An observation without weight has no
    /// error (NaN).
    ///
    /// # Errors
    /// If the columns of the rows are not those of the model.
    pub fn left_out_errors(&self, data: &Data) -> Result<Option<Vec<f64>>, ModelError> {
        let Some(evidence) = self.fit.evidence else { return Ok(None) };
        let scaled = scale(data, &self.input_scalers, &self.output_scaler);
        let Some(mut problem) = self.network.gauss_newton(Isa::detect(), &scaled)? else { return Ok(None) };
        let shift = evidence.alpha / evidence.beta;
        let errors = left_out_of(problem.as_mut(), self.network.weights(), &scaled, shift);
        let unit = self.output_scaler.inverse_factor();
        Ok(errors.map(|errors| errors.iter().map(|error| error * unit).collect()))
    }

    /// The same model with intervals that hold for the given errors of left-out blocks instead of those of
    /// [`Model::left_out_errors`]: for predictions in which the model has only a part.
    ///
    /// # Errors
    /// If the columns of the rows are not those of the model.
    pub fn with_left_out_errors(mut self, data: &Data, errors: &[f64]) -> Result<Model, ModelError> {
        // The errors are compared with deviations that were not yet calibrated.
        self.fit.intervals = None;
        self.fit.intervals = self.intervals_of(data, Some(errors))?;
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trainer::{LevenbergMarquardt, NoObserver, by_name};
    use crate::{ModelColumn, ModelDefinition};

    fn runs(count: usize) -> Data {
        let x: Vec<f64> = (0..count * 12).map(|k| (k % 12) as f64 / 11.0).collect();
        let y = (0..count * 12).map(|k| x[k] * x[k] + 0.05 * ((k / 12) as f64 - 1.5)).collect();
        let blocks = (0..count * 12).map(|k| k / 12).collect();
        Data::new(x, 1, y).unwrap().with_blocks(blocks).unwrap()
    }

    #[test]
    fn errors_of_a_loaded_model_are_those_of_its_training() {
        let (data, trainer) = (runs(4), LevenbergMarquardt::default());
        let definition =
            ModelDefinition::new(vec![ModelColumn::new("x", "1")], ModelColumn::new("y", "1"), vec![4]);
        let (model, report) = Model::fit(&definition, &data, &trainer, &mut NoObserver).unwrap();
        let unit = model.output_scaler().inverse_factor();
        let expected: Vec<f64> = report.left_out.unwrap().iter().map(|error| error * unit).collect();
        let loaded = Model::from_json(&model.to_json(), "model").unwrap();
        let errors = loaded.left_out_errors(&data).unwrap().unwrap();
        assert_eq!(errors, expected);
        // Twice the errors give intervals of twice the width, and the same ones give the same.
        let same = loaded.clone().with_left_out_errors(&data, &errors).unwrap();
        assert_eq!(same.training_fit().intervals, model.training_fit().intervals);
        let twice: Vec<f64> = errors.iter().map(|error| 2.0 * error).collect();
        let wide = loaded.with_left_out_errors(&data, &twice).unwrap();
        let width = |model: &Model| model.standard_deviations(&[0.4]).unwrap().unwrap()[0];
        assert!((width(&wide) / width(&model) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn one_block_or_another_trainer_gives_none() {
        let definition =
            ModelDefinition::new(vec![ModelColumn::new("x", "1")], ModelColumn::new("y", "1"), vec![4]);
        let (data, trainer) = (runs(1), LevenbergMarquardt::default());
        let model = Model::fit(&definition, &data, &trainer, &mut NoObserver).unwrap().0;
        assert_eq!(model.left_out_errors(&data).unwrap(), None);
        let (data, trainer) = (runs(2), by_name("l-bfgs", &Default::default()).unwrap());
        let model = Model::fit(&definition, &data, trainer.as_ref(), &mut NoObserver).unwrap().0;
        assert_eq!(model.left_out_errors(&data).unwrap(), None);
    }
}
