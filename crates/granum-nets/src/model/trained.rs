//! A trained network with everything that is needed to use it: columns, scalers, ranges, provenance and uncertainty.

use std::sync::OnceLock;

use granum_core::observer::Observer;

use crate::feed_forward::forward::RowNetwork;
use crate::feed_forward::network::Network;
use crate::model::intervals::Intervals;
use crate::model::model_definition::{ModelColumn, ModelDefinition};
use crate::model::model_error::ModelError;
use crate::model::provenance::{Fit, Provenance};
use crate::model::uncertainty::{Laplace, TrainingRows};
use crate::table::data::Data;
use crate::table::scaler::Scaler;
use crate::trainer::report::TrainingReport;
use crate::trainer::state::TrainerState;
use crate::trainer::trainer_trait::Trainer;

/// Predictions whose range is below this fraction of the range of the targets are considered constant.
const CONSTANT: f64 = 1e-3;

/// A trained network in the units of its columns.
///
/// ```
/// use granum_nets::trainer::{LevenbergMarquardt, NoObserver};
/// use granum_nets::{ModelColumn, Data, Model, ModelDefinition};
///
/// let x: Vec<f64> = (0..30).map(|k| k as f64 / 29.0).collect();
/// let y = x.iter().map(|x| 2.0 * x * x).collect();
/// let definition = ModelDefinition::new(vec![ModelColumn::new("x", "m")], ModelColumn::new("y", "m2"), vec![4]);
/// let trainer = LevenbergMarquardt::default();
/// let (model, _) = Model::fit(&definition, &Data::new(x, 1, y)?, &trainer, &mut NoObserver)?;
/// // A saved model is read back with identical bits.
/// let back = Model::from_json(&model.to_json(), "model.json")?;
/// assert_eq!(back.value(&[0.5])?, model.value(&[0.5])?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) inputs: Vec<ModelColumn>,
    pub(crate) output: ModelColumn,
    pub(crate) input_scalers: Vec<Scaler>,
    pub(crate) output_scaler: Scaler,
    pub(crate) network: Network,
    pub(crate) provenance: Provenance,
    pub(crate) fit: Fit,
    pub(crate) training_rows: Option<TrainingRows>,
    pub(crate) rows: RowNetwork,
    pub(crate) laplace: OnceLock<Option<Laplace>>,
}

impl Model {
    /// Scales the rows, trains a new network on them, and returns it with its scalers and the report.
    ///
    /// Inputs are scaled to [-1, 1] by their range over the training rows, targets to [0.1, 0.9].
    ///
    /// # Errors
    /// If the columns do not match the data, the network is too large, or the trainer returns an error.
    pub fn fit(
        definition: &ModelDefinition,
        data: &Data,
        trainer: &dyn Trainer,
        observer: &mut dyn Observer,
    ) -> Result<(Model, TrainingReport), ModelError> {
        Model::resume(definition, data, trainer, None, observer)
    }

    /// As [`Model::fit`], but continues from the state of an interrupted training. The result is identical bit by bit to
    /// that of an uninterrupted training.
    ///
    /// # Errors
    /// As [`Model::fit`], and if the state belongs to another training.
    pub fn resume(
        definition: &ModelDefinition,
        data: &Data,
        trainer: &dyn Trainer,
        state: Option<TrainerState>,
        observer: &mut dyn Observer,
    ) -> Result<(Model, TrainingReport), ModelError> {
        if data.target_columns() != 1 {
            return Err(ModelError::Columns(format!(
                "a model has one output, the data have {}",
                data.target_columns()
            )));
        }
        if data.input_columns() != definition.inputs.len() {
            return Err(ModelError::Columns(format!(
                "the definition names {} inputs, the data have {} columns",
                definition.inputs.len(),
                data.input_columns()
            )));
        }
        let mut network = definition.network()?;
        let mut input_scalers = Scaler::fit_columns(data.inputs(), data.input_columns(), Scaler::INPUT_RANGE);
        Scaler::share(&mut input_scalers, &definition.quantities);
        for (scaler, share) in input_scalers.iter_mut().zip(&definition.shares) {
            (scaler.low, scaler.high) = (share * scaler.low, share * scaler.high);
        }
        let output_scaler = Scaler::fit(data.targets().iter().copied(), Scaler::SIGMOID_RANGE);
        let scaled = scale(data, &input_scalers, &output_scaler);
        let report = trainer.resume(&mut network, &scaled, state, observer)?;
        let unit = output_scaler.inverse_factor();
        let fit = Fit {
            rms_error: report.error.sqrt() * unit,
            validation_rms_error: report.validation_error.map(|e| e.sqrt() * unit),
            noise: report.evidence.map(|e| unit / e.beta.sqrt()),
            evidence: report.evidence,
            answer_range: None,
            intervals: None,
        };
        let provenance = Provenance::new(data, definition.seed, &report);
        let columns = (definition.inputs.clone(), definition.output.clone());
        // The uncertainty of predictions is computed from these rows.
        let rows = report.evidence.map(|_| TrainingRows {
            inputs: scaled.inputs,
            weights: scaled.weights,
            points: scaled.points,
        });
        let mut model =
            Model::assemble(columns, input_scalers, output_scaler, network, provenance, fit, rows);
        model.fit.answer_range = model.answer_range(data)?;
        let left_out: Option<Vec<f64>> =
            report.left_out.as_ref().map(|errors| errors.iter().map(|error| error * unit).collect());
        model.fit.intervals = model.intervals_of(data, left_out.as_deref())?;
        Ok((model, report))
    }

    /// Smallest and largest prediction for the observations.
    fn answer_range(&self, data: &Data) -> Result<Option<[f64; 2]>, ModelError> {
        let values = self.predict_batch(data.inputs())?.values;
        let means =
            values.chunks(data.points()).map(|points| points.iter().sum::<f64>() / points.len() as f64);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let range = means.fold(none, |[low, high], value| [low.min(value), high.max(value)]);
        Ok(range.iter().all(|end| end.is_finite()).then_some(range))
    }

    /// Compares the errors of left-out blocks, in the unit of the output, with the standard deviations of the training
    /// observations.
    pub(crate) fn intervals_of(
        &self,
        data: &Data,
        left_out: Option<&[f64]>,
    ) -> Result<Option<Intervals>, ModelError> {
        let Some(errors) = left_out else { return Ok(None) };
        let Some(deviations) = self.standard_deviations_of(data.inputs(), data.points())? else {
            return Ok(None);
        };
        let names: Vec<&str> = self.inputs.iter().map(|column| column.name.as_str()).collect();
        Ok(Intervals::new(data, &names, errors, &deviations))
    }

    pub(crate) fn assemble(
        (inputs, output): (Vec<ModelColumn>, ModelColumn),
        input_scalers: Vec<Scaler>,
        output_scaler: Scaler,
        network: Network,
        provenance: Provenance,
        fit: Fit,
        training_rows: Option<TrainingRows>,
    ) -> Model {
        let rows = RowNetwork::new(&network);
        let laplace = OnceLock::new();
        Model {
            inputs,
            output,
            input_scalers,
            output_scaler,
            network,
            provenance,
            fit,
            training_rows,
            rows,
            laplace,
        }
    }

    /// Input columns, in the order of a row.
    pub fn inputs(&self) -> &[ModelColumn] {
        &self.inputs
    }

    /// Output column.
    pub fn output(&self) -> &ModelColumn {
        &self.output
    }

    /// Scalers of the inputs; their `minimum` and `maximum` are the trained range of the model.
    pub fn input_scalers(&self) -> &[Scaler] {
        &self.input_scalers
    }

    /// Scaler of the output.
    pub fn output_scaler(&self) -> &Scaler {
        &self.output_scaler
    }

    /// The network, in scaled units.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// The origin of the model.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// The quality of the fit to the training rows.
    pub fn training_fit(&self) -> &Fit {
        &self.fit
    }

    /// Number of blocks (runs) of training rows from which the standard deviations were calibrated. `None` if there was
    /// only one block, in which case they do not include the differences between blocks.
    pub fn blocks(&self) -> Option<usize> {
        self.fit.intervals.as_ref().map(|intervals| intervals.blocks)
    }

    /// True if the network learned a constant: the range of its predictions for the training rows is at most a thousandth
    /// of the range of the targets.
    pub fn is_constant(&self) -> bool {
        let range = self.output_scaler.maximum - self.output_scaler.minimum;
        self.fit.answer_range.is_some_and(|[low, high]| high - low <= CONSTANT * range)
    }

    /// Half width, in standard deviations, of an interval that contains the given share of the observations: the quantile of
    /// Student's t distribution if the standard deviations were calibrated with blocks, otherwise that of the normal
    /// distribution.
    pub fn quantile(&self, level: f64) -> f64 {
        let degrees = self.fit.intervals.as_ref().map_or(f64::INFINITY, |i| i.degrees_of_freedom);
        crate::statistics::student_t::two_sided_quantile(level, degrees)
    }
}

/// The rows in the scaled units of the network.
pub(crate) fn scale(data: &Data, inputs: &[Scaler], output: &Scaler) -> Data {
    Data {
        inputs: data.inputs.iter().enumerate().map(|(i, v)| inputs[i % inputs.len()].scale(*v)).collect(),
        targets: data.targets.iter().map(|v| output.scale(*v)).collect(),
        validation: data.validation().map(|v| Box::new(scale(v, inputs, output))),
        weights: data.weights.clone(),
        blocks: data.blocks.clone(),
        sequences: data.sequences.clone(),
        ..*data
    }
}
