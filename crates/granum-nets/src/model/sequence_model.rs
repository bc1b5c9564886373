//! A trained recurrent unit in the units of its columns.

use granum_core::observer::Observer;
use granum_simd::Isa;
use serde::{Deserialize, Serialize};

use crate::differentiable::Differentiable;
use crate::model::model_definition::ModelColumn;
use crate::model::model_error::ModelError;
use crate::model::provenance::Provenance;
use crate::recurrent::gru::Gru;
use crate::table::data::Data;
use crate::table::scaler::Scaler;
use crate::table::sequences::Sequences;
use crate::trainer::report::TrainingReport;
use crate::trainer::state::TrainerState;
use crate::trainer::trainer_trait::Trainer;

/// The definition of a sequence model: columns, number of hidden neurons and seed.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceDefinition {
    /// Input columns, in the order of the rows.
    pub inputs: Vec<ModelColumn>,
    /// Output columns.
    pub outputs: Vec<ModelColumn>,
    /// Number of hidden neurons, which are the memory of the model.
    pub hidden: usize,
    /// Seed of the initial weights.
    pub seed: u64,
}

/// A [`Gru`] in the units of its columns. Its state before the first row of a sequence is computed from the inputs of that
/// row.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver};
/// use granum_nets::{ModelColumn, Data, SequenceDefinition, SequenceModel, Sequences};
///
/// // A moving average of the present and the last input, in kPa.
/// let x: Vec<f64> = (0..120).map(|k| (1.9 * f64::from(k)).sin()).collect();
/// let y = (0..120).map(|k| 50.0 * (x[k] + if k % 6 == 0 { x[k] } else { x[k - 1] })).collect();
/// let data = Data::new(x.clone(), 1, y)?.with_sequences(Sequences::new(vec![6; 20])?)?;
/// let column = |name, unit| vec![ModelColumn::new(name, unit)];
/// let definition =
///     SequenceDefinition { inputs: column("x", "1"), outputs: column("y", "kPa"), hidden: 6, seed: 1 };
/// let trainer = Adam { epochs: 300, learning_rate: 0.02, ..Adam::default() };
/// let (model, _) = SequenceModel::fit(&definition, &data, &trainer, &mut NoObserver)?;
/// let predictions = model.predict(&[0.2, 0.6, -0.4], &[3])?;
/// assert!((predictions[1] - 40.0).abs() < 8.0 && (predictions[2] - 10.0).abs() < 8.0, "{predictions:?}");
/// let back = SequenceModel::from_value(&model.to_value()?, "model")?;
/// assert_eq!(back.predict(&[0.2, 0.6, -0.4], &[3])?, predictions);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceModel {
    inputs: Vec<ModelColumn>,
    outputs: Vec<ModelColumn>,
    input_scalers: Vec<Scaler>,
    output_scalers: Vec<Scaler>,
    gru: Gru,
    provenance: Provenance,
}

impl SequenceModel {
    /// Scales the rows of the sequences, trains a new recurrent unit on them, and returns it with the report. Inputs and
    /// targets are scaled to [-1, 1] by their ranges over the training rows.
    ///
    /// # Errors
    /// If the columns do not match the data, the rows are not divided into sequences, there are too many hidden neurons, or
    /// the trainer returns an error.
    pub fn fit(
        definition: &SequenceDefinition,
        data: &Data,
        trainer: &dyn Trainer,
        observer: &mut dyn Observer,
    ) -> Result<(SequenceModel, TrainingReport), ModelError> {
        SequenceModel::resume(definition, data, trainer, None, observer)
    }

    /// As [`SequenceModel::fit`], but continues from the state of an interrupted training, to the same bits.
    ///
    /// # Errors
    /// As [`SequenceModel::fit`], and if the state belongs to another training.
    pub fn resume(
        definition: &SequenceDefinition,
        data: &Data,
        trainer: &dyn Trainer,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<(SequenceModel, TrainingReport), ModelError> {
        let (inputs, outputs) = (definition.inputs.len(), definition.outputs.len());
        if (data.input_columns(), data.target_columns()) != (inputs, outputs) {
            return Err(ModelError::Columns(format!(
                "the definition names {inputs} inputs and {outputs} outputs, the data have {} and {} columns",
                data.input_columns(),
                data.target_columns()
            )));
        }
        if data.sequences().is_none_or(|sequences| sequences.start_columns() > 0) {
            let text = "a sequence model needs rows that are divided into sequences without start vectors";
            return Err(ModelError::Columns(text.into()));
        }
        let input_scalers = Scaler::fit_columns(data.inputs(), inputs, Scaler::INPUT_RANGE);
        let output_scalers = Scaler::fit_columns(data.targets(), outputs, Scaler::INPUT_RANGE);
        let scaled = scale(data, &input_scalers, &output_scalers)?;
        let mut gru = Gru::new(inputs, inputs, definition.hidden, outputs, definition.seed)?;
        let report = trainer.resume(&mut gru, &scaled, state, observer)?;
        let provenance = Provenance::new(data, definition.seed, &report);
        let (inputs, outputs) = (definition.inputs.clone(), definition.outputs.clone());
        Ok((SequenceModel { inputs, outputs, input_scalers, output_scalers, gru, provenance }, report))
    }

    /// The outputs, `rows x outputs`, for the rows of consecutive sequences with the given lengths, `rows x inputs`.
    ///
    /// # Errors
    /// If the number of values is wrong, a value is not finite, or a sequence has no row.
    pub fn predict(&self, inputs: &[f64], lengths: &[usize]) -> Result<Vec<f64>, ModelError> {
        let columns = self.inputs.len();
        let sequences = Sequences::new(lengths.to_vec())?;
        if let Some(place) = inputs.iter().position(|value| !value.is_finite()) {
            let (row, name) = (place / columns, self.inputs[place % columns].name.clone());
            return Err(ModelError::NotFinite { row, name, value: inputs[place] });
        }
        let scaled: Vec<f64> = inputs
            .iter()
            .enumerate()
            .map(|(k, value)| self.input_scalers[k % columns].scale(*value))
            .collect();
        if scaled.len() != sequences.rows() * columns {
            let rows = sequences.rows();
            let text = format!("{rows} rows of {columns} inputs are needed, not {} values", inputs.len());
            return Err(ModelError::Columns(text));
        }
        let sequences = with_starts(sequences, &scaled, columns)?;
        let mut predictions = self.gru.evaluate(Isa::detect(), &scaled, Some(&sequences))?;
        for (k, prediction) in predictions.iter_mut().enumerate() {
            *prediction = self.output_scalers[k % self.outputs.len()].unscale(*prediction);
        }
        Ok(predictions)
    }

    /// Input columns, in the order of a row.
    pub fn inputs(&self) -> &[ModelColumn] {
        &self.inputs
    }

    /// Output columns.
    pub fn outputs(&self) -> &[ModelColumn] {
        &self.outputs
    }

    /// Scalers of the inputs; their `minimum` and `maximum` are the trained range of the model.
    pub fn input_scalers(&self) -> &[Scaler] {
        &self.input_scalers
    }

    /// Scalers of the outputs.
    pub fn output_scalers(&self) -> &[Scaler] {
        &self.output_scalers
    }

    /// The recurrent unit, in scaled units.
    pub fn gru(&self) -> &Gru {
        &self.gru
    }

    /// The origin of the model.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// The content of a file of the model, as a part of a larger file.
    ///
    /// # Errors
    /// If a number cannot be represented in JSON.
    pub fn to_value(&self) -> Result<serde_json::Value, ModelError> {
        let columns = |columns: &[ModelColumn], scalers: &[Scaler]| {
            let column = |(column, scaler): (&ModelColumn, &Scaler)| FileColumn {
                name: column.name.clone(),
                unit: column.unit.clone(),
                scaler: *scaler,
            };
            columns.iter().zip(scalers).map(column).collect()
        };
        let file = File {
            format: FORMAT.into(),
            version: VERSION,
            inputs: columns(&self.inputs, &self.input_scalers),
            outputs: columns(&self.outputs, &self.output_scalers),
            provenance: self.provenance.clone(),
            hidden: self.gru.hidden(),
            weights: self.gru.weights().to_vec(),
        };
        serde_json::to_value(file).map_err(|error| failed("model", error.to_string()))
    }

    /// Recreates a model from the result of [`SequenceModel::to_value`]; `name` is used in error messages.
    ///
    /// # Errors
    /// If the value is not a sequence model, or is of a newer version.
    pub fn from_value(value: &serde_json::Value, name: &str) -> Result<SequenceModel, ModelError> {
        let file = File::deserialize(value)
            .map_err(|error| failed(name, format!("not a usable sequence model: {error}")))?;
        if file.format != FORMAT || file.version != VERSION {
            let wanted = format!("this program reads \"{FORMAT}\" version {VERSION}");
            let (format, version) = (file.format, file.version);
            return Err(failed(name, format!("found format \"{format}\" version {version}; {wanted}")));
        }
        let (inputs, input_scalers) = split(file.inputs, name)?;
        let (outputs, output_scalers) = split(file.outputs, name)?;
        let gru = Gru::from_weights(inputs.len(), inputs.len(), file.hidden, outputs.len(), file.weights)?;
        Ok(SequenceModel { inputs, outputs, input_scalers, output_scalers, gru, provenance: file.provenance })
    }
}

const FORMAT: &str = "granum sequence model";
const VERSION: u64 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u64,
    inputs: Vec<FileColumn>,
    outputs: Vec<FileColumn>,
    provenance: Provenance,
    hidden: usize,
    weights: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileColumn {
    name: String,
    unit: String,
    scaler: Scaler,
}

fn failed(name: &str, problem: String) -> ModelError {
    ModelError::File { path: name.to_string(), problem }
}

/// Columns and their scalers, whose numbers are checked.
fn split(columns: Vec<FileColumn>, name: &str) -> Result<(Vec<ModelColumn>, Vec<Scaler>), ModelError> {
    for FileColumn { name: column, scaler, .. } in &columns {
        let Scaler { minimum, maximum, low, high } = *scaler;
        let finite = [minimum, maximum, low, high, maximum - minimum].iter().all(|v| v.is_finite());
        if !(finite && minimum <= maximum && low < high) {
            let text = format!("column {column}: its scaler needs finite minimum <= maximum and low < high");
            return Err(failed(name, text));
        }
    }
    Ok(columns.into_iter().map(|c| (ModelColumn { name: c.name, unit: c.unit }, c.scaler)).unzip())
}

/// The sequences with the inputs of their first rows as start vectors.
fn with_starts(sequences: Sequences, inputs: &[f64], columns: usize) -> Result<Sequences, ModelError> {
    let first = |rows: std::ops::Range<usize>| &inputs[rows.start * columns..(rows.start + 1) * columns];
    let starts = sequences.ranges().into_iter().flat_map(first).copied().collect();
    Ok(sequences.with_starts(starts, columns)?)
}

/// The rows in the scaled units of the recurrent unit, with start vectors.
fn scale(data: &Data, inputs: &[Scaler], outputs: &[Scaler]) -> Result<Data, ModelError> {
    let scaled = |values: &[f64], scalers: &[Scaler]| -> Vec<f64> {
        values.iter().enumerate().map(|(k, value)| scalers[k % scalers.len()].scale(*value)).collect()
    };
    let rows = scaled(&data.inputs, inputs);
    let sequences = data.sequences.clone().map(|sequences| with_starts(sequences, &rows, inputs.len()));
    let validation = data.validation().map(|rows| scale(rows, inputs, outputs)).transpose()?;
    Ok(Data {
        inputs: rows,
        targets: scaled(&data.targets, outputs),
        sequences: sequences.transpose()?,
        weights: data.weights.clone(),
        blocks: data.blocks.clone(),
        validation: validation.map(Box::new),
        ..*data
    })
}
