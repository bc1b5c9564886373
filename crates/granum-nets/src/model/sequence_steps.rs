//! A sequence model whose rows come one after the other.

use granum_simd::Isa;

use crate::differentiable::Differentiable;
use crate::model::model_error::ModelError;
use crate::model::sequence_model::SequenceModel;
use crate::sequence::stepper::Stepper;
use crate::table::scaler::Scaler;

/// A sequence whose rows come one after the other, from [`SequenceModel::steps`]. The outputs have the bits of [`SequenceModel::predict`] for the
/// rows together.
pub struct SequenceSteps {
    input_scalers: Vec<Scaler>,
    output_scalers: Vec<Scaler>,
    stepper: Box<dyn Stepper>,
    scaled: Vec<f64>,
}

impl SequenceModel {
    /// A sequence that begins with a row of inputs, which is not yet predicted.
    ///
    /// ```
    /// use granum_nets::trainer::{Adam, NoObserver};
    /// use granum_nets::{Data, ModelColumn, SequenceDefinition, SequenceModel, Sequences};
    ///
    /// let x: Vec<f64> = (0..60).map(|k| (1.9 * f64::from(k)).sin()).collect();
    /// let data = Data::new(x.clone(), 1, x)?.with_sequences(Sequences::new(vec![6; 10])?)?;
    /// let column = |name| vec![ModelColumn::new(name, "1")];
    /// let definition = SequenceDefinition { inputs: column("x"), outputs: column("y"), hidden: 3, seed: 1 };
    /// let trainer = Adam { epochs: 5, ..Adam::default() };
    /// let (model, _) = SequenceModel::fit(&definition, &data, &trainer, &mut NoObserver)?;
    /// let together = model.predict(&[0.2, 0.6], &[2])?;
    /// let mut steps = model.steps(&[0.2])?;
    /// let mut output = [0.0];
    /// steps.predict(&[0.2], &mut output)?;
    /// assert_eq!(output[0], together[0]);
    /// steps.accept();
    /// steps.predict(&[0.6], &mut output)?;
    /// assert_eq!(output[0], together[1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the row has another number of values.
    pub fn steps(&self, first: &[f64]) -> Result<SequenceSteps, ModelError> {
        let scaled = self.scaled_row(first)?;
        let stepper = self.gru().stepper(Isa::detect(), 1, &scaled)?;
        let (input_scalers, output_scalers) = (self.input_scalers().to_vec(), self.output_scalers().to_vec());
        Ok(SequenceSteps { input_scalers, output_scalers, stepper, scaled })
    }

    fn scaled_row(&self, row: &[f64]) -> Result<Vec<f64>, ModelError> {
        let columns = self.inputs().len();
        if row.len() != columns {
            return Err(ModelError::Columns(format!("a row has {columns} inputs, not {}", row.len())));
        }
        Ok(self.input_scalers().iter().zip(row).map(|(scaler, value)| scaler.scale(*value)).collect())
    }
}

impl SequenceSteps {
    /// The outputs for the next row. The state stays what it was before the row.
    ///
    /// # Errors
    /// If the row or the outputs have another number of values.
    pub fn predict(&mut self, row: &[f64], outputs: &mut [f64]) -> Result<(), ModelError> {
        let (columns, width) = (self.input_scalers.len(), self.output_scalers.len());
        if (row.len(), outputs.len()) != (columns, width) {
            let text = format!(
                "a row has {columns} inputs and {width} outputs, not {} and {}",
                row.len(),
                outputs.len()
            );
            return Err(ModelError::Columns(text));
        }
        for ((scaled, scaler), value) in self.scaled.iter_mut().zip(&self.input_scalers).zip(row) {
            *scaled = scaler.scale(*value);
        }
        self.stepper.predict(&self.scaled, outputs)?;
        for (output, scaler) in outputs.iter_mut().zip(&self.output_scalers) {
            *output = scaler.unscale(*output);
        }
        Ok(())
    }

    /// The state after the row that was predicted last becomes that before the next one.
    pub fn accept(&mut self) {
        self.stepper.accept();
    }

    /// The state before the next row as a value; empty before the first row was accepted.
    pub fn state(&self) -> Vec<f64> {
        self.stepper.state()
    }

    /// Goes on from a state that [`SequenceSteps::state`] gave, of any sequence of the same model, with the same bits.
    ///
    /// # Errors
    /// If it is not the state of such a model.
    pub fn set_state(&mut self, state: &[f64]) -> Result<(), ModelError> {
        Ok(self.stepper.set_state(state)?)
    }
}
