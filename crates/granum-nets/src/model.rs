//! A trained network with everything that its use needs: columns, scalers, ranges, provenance, uncertainty.

use std::path::Path;
use std::sync::OnceLock;

use granum_simd::Isa;
use serde::{Deserialize, Serialize};

use crate::data::{Data, DataError};
use crate::forward::{self, RowNetwork, Scalers};
use crate::intervals::Intervals;
use crate::model_file;
use crate::network::{Network, NetworkError};
use crate::scaler::Scaler;
use crate::trainer::{
    Evidence, Observer, TerminationReason, Trainer, TrainerState, TrainingError, TrainingReport,
};
use crate::uncertainty::{Laplace, TrainingRows};

/// Why a model cannot be fitted, used, saved or loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The shape of the network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The rows.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The training.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// Columns of a recipe do not fit the data.
    #[error("{0}")]
    Columns(String),
    /// A row to predict has the wrong length.
    #[error("a row for this model has {expected} inputs ({names}), not {given}")]
    RowLength {
        /// Inputs of the model.
        expected: usize,
        /// Their names.
        names: String,
        /// Length of the row.
        given: usize,
    },
    /// A value to predict from is not finite.
    #[error("row {row}, input {name}: {value} is not a finite number")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// Name of the input.
        name: String,
        /// The value.
        value: f64,
    },
    /// MacroState or writing failed.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no model, or damaged, or newer than this program.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: String,
        /// What is wrong and what would be right.
        problem: String,
    },
}

/// Name and unit of a column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Name, e.g. `deviator_strain`.
    pub name: String,
    /// Unit, e.g. `Pa`; `1` for a pure number.
    pub unit: String,
}

impl Column {
    /// A column with its unit.
    pub fn new(name: &str, unit: &str) -> Column {
        Column { name: name.into(), unit: unit.into() }
    }
}

/// What to fit: the columns, the size of the network and the seed of its weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Input columns, in the order of the rows.
    pub inputs: Vec<Column>,
    /// Output column.
    pub output: Column,
    /// Which columns are parts of one quantity, such as the bins of a distribution: columns with the same number are scaled
    /// together, so that they keep their proportions and all of them weigh as much as one input. Empty: each column is a
    /// quantity of its own.
    pub quantities: Vec<usize>,
    /// How much of the range of an input each column is given: 1 for [-1, 1], 0.3 for [-0.3, 0.3]. All weights are held back
    /// alike, so an input that is given less is believed less until the rows speak for it. Empty: all of it.
    pub shares: Vec<f64>,
    /// Neurons of each hidden layer; the paper's networks have two.
    pub hidden: Vec<usize>,
    /// Seed of the initial weights.
    pub seed: u64,
}

impl Recipe {
    /// Neurons of all layers, inputs and output included.
    pub fn layers(&self) -> Vec<usize> {
        let mut layers = vec![self.inputs.len()];
        layers.extend(&self.hidden);
        layers.push(1);
        layers
    }

    /// The network before training.
    ///
    /// # Errors
    /// If a layer is empty or too large.
    pub fn network(&self) -> Result<Network, NetworkError> {
        Network::new(&self.layers(), self.seed)
    }
}

/// Where a model comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of granum that trained it.
    pub granum_version: String,
    /// Hash of the rows it was trained on, see [`Data::hash`].
    pub dataset_hash: String,
    /// Number of those rows.
    pub rows: usize,
    /// Seed of the initial weights.
    pub seed: u64,
    /// Name of the trainer.
    pub trainer: String,
    /// Epochs that it took.
    pub epochs: u64,
    /// Why it ended.
    pub termination: TerminationReason,
}

/// How well a model fits the rows it was trained on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Root of the mean squared error over the training rows, in the unit of the output.
    pub rms_error: f64,
    /// The same over the validation rows, if there were any.
    pub validation_rms_error: Option<f64>,
    /// Standard deviation of the noise in the targets as Bayesian regularisation estimates it, in the unit of the
    /// output.
    pub noise: Option<f64>,
    /// What Bayesian regularisation found, in scaled units.
    pub evidence: Option<Evidence>,
    /// Least and largest answer to the training observations, in the unit of the output.
    #[serde(default)]
    pub answer_range: Option<[f64; 2]>,
    /// How much farther than the Laplace approximation says new blocks (runs) are off, where there were several.
    #[serde(default)]
    pub intervals: Option<Intervals>,
}

/// Share of the range of the targets below which answers that differ are called constant.
const CONSTANT: f64 = 1e-3;

/// A trained network in the units of its columns.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) inputs: Vec<Column>,
    pub(crate) output: Column,
    pub(crate) input_scalers: Vec<Scaler>,
    pub(crate) output_scaler: Scaler,
    pub(crate) network: Network,
    pub(crate) provenance: Provenance,
    pub(crate) fit: Fit,
    pub(crate) training_rows: Option<TrainingRows>,
    rows: RowNetwork,
    laplace: OnceLock<Option<Laplace>>,
}

/// One predicted value.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The value, in the unit of the output.
    pub value: f64,
    /// Standard deviation of an observation around it (noise and uncertainty of the weights), if the model knows it.
    pub standard_deviation: Option<f64>,
    /// Names of the inputs that lie outside the range the model was trained in.
    pub outside: Vec<String>,
}

/// Predicted values of many rows.
#[derive(Clone, Debug, PartialEq)]
pub struct BatchPrediction {
    /// One value a row, in the unit of the output.
    pub values: Vec<f64>,
    /// True for a row with an input outside the range the model was trained in.
    pub outside: Vec<bool>,
}

impl Model {
    /// Scales the rows, trains a fresh network on them and returns it with its scalers and the report.
    ///
    /// Inputs are scaled to [-1, 1] by their range over the training rows, targets to [0.1, 0.9].
    ///
    /// # Errors
    /// If the columns do not fit, the network is too large or the trainer refuses.
    pub fn fit(
        recipe: &Recipe,
        data: &Data,
        trainer: &dyn Trainer,
        observer: &mut dyn Observer,
    ) -> Result<(Model, TrainingReport), ModelError> {
        Model::resume(recipe, data, trainer, None, observer)
    }

    /// As [`Model::fit`], going on from the state of an interrupted training. The result has the bits of a training
    /// that was never interrupted.
    ///
    /// # Errors
    /// As [`Model::fit`], and if the state belongs to another training.
    pub fn resume(
        recipe: &Recipe,
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
        if data.input_columns() != recipe.inputs.len() {
            return Err(ModelError::Columns(format!(
                "the recipe names {} inputs, the data have {} columns",
                recipe.inputs.len(),
                data.input_columns()
            )));
        }
        let mut network = recipe.network()?;
        let mut input_scalers = Scaler::fit_columns(data.inputs(), data.input_columns(), Scaler::INPUT_RANGE);
        Scaler::share(&mut input_scalers, &recipe.quantities);
        for (scaler, share) in input_scalers.iter_mut().zip(&recipe.shares) {
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
        let provenance = Provenance {
            granum_version: env!("CARGO_PKG_VERSION").into(),
            dataset_hash: data.hash(),
            rows: data.rows(),
            seed: recipe.seed,
            trainer: report.trainer.into(),
            epochs: report.epochs,
            termination: report.termination,
        };
        let columns = (recipe.inputs.clone(), recipe.output.clone());
        // What the uncertainty of a prediction is computed from.
        let rows = report.evidence.map(|_| TrainingRows {
            inputs: scaled.inputs,
            weights: scaled.weights,
            points: scaled.points,
        });
        let mut model =
            Model::assemble(columns, input_scalers, output_scaler, network, provenance, fit, rows);
        model.fit.answer_range = model.answer_range(data)?;
        model.fit.intervals = model.intervals_of(data, report.left_out.as_deref())?;
        Ok((model, report))
    }

    /// Least and largest answer to the observations.
    fn answer_range(&self, data: &Data) -> Result<Option<[f64; 2]>, ModelError> {
        let values = self.predict_batch(data.inputs())?.values;
        let means =
            values.chunks(data.points()).map(|points| points.iter().sum::<f64>() / points.len() as f64);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let range = means.fold(none, |[low, high], value| [low.min(value), high.max(value)]);
        Ok(range.iter().all(|end| end.is_finite()).then_some(range))
    }

    /// What the errors of left-out blocks say of the standard deviations of the training observations.
    fn intervals_of(&self, data: &Data, left_out: Option<&[f64]>) -> Result<Option<Intervals>, ModelError> {
        let Some(left_out) = left_out else { return Ok(None) };
        let Some(deviations) = self.standard_deviations_of(data.inputs(), data.points())? else {
            return Ok(None);
        };
        let unit = self.output_scaler.inverse_factor();
        let errors: Vec<f64> = left_out.iter().map(|error| error * unit).collect();
        let names: Vec<&str> = self.inputs.iter().map(|column| column.name.as_str()).collect();
        Ok(Intervals::new(data, &names, &errors, &deviations))
    }

    pub(crate) fn assemble(
        (inputs, output): (Vec<Column>, Column),
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
    pub fn inputs(&self) -> &[Column] {
        &self.inputs
    }

    /// Output column.
    pub fn output(&self) -> &Column {
        &self.output
    }

    /// Scalers of the inputs; their `minimum` and `maximum` are the range that the model was trained in.
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

    /// Where the model comes from.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// How well it fits the rows it was trained on.
    pub fn training_fit(&self) -> &Fit {
        &self.fit
    }

    /// How many blocks (runs) of the training rows the standard deviations were judged by; none if there was but one, and
    /// they do not contain what blocks differ by.
    pub fn blocks(&self) -> Option<usize> {
        self.fit.intervals.as_ref().map(|intervals| intervals.blocks)
    }

    /// True if the network learned a constant: its answers to the training rows differ by no more than a thousandth of the
    /// range of the targets.
    pub fn is_constant(&self) -> bool {
        let range = self.output_scaler.maximum - self.output_scaler.minimum;
        self.fit.answer_range.is_some_and(|[low, high]| high - low <= CONSTANT * range)
    }

    /// Of how many standard deviations an interval reaches to either side so that it holds that share of the observations:
    /// Student's quantile where the deviations were judged by blocks, else the normal one.
    pub fn quantile(&self, level: f64) -> f64 {
        let degrees = self.fit.intervals.as_ref().map_or(f64::INFINITY, |i| i.degrees_of_freedom);
        crate::student_t::two_sided_quantile(level, degrees)
    }

    /// Predicts one row, with what there is to say about its trustworthiness.
    ///
    /// # Errors
    /// If the row has the wrong length or a value is not finite.
    pub fn predict(&self, row: &[f64]) -> Result<Prediction, ModelError> {
        let value = self.value(row)?;
        let standard_deviation = self.standard_deviations(row)?.map(|d| d[0]);
        Ok(Prediction { value, standard_deviation, outside: self.outside(row) })
    }

    /// The value of one row alone: what a control loop calls.
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

    /// Names of the inputs of a row that lie outside the range the model was trained in.
    pub fn outside(&self, row: &[f64]) -> Vec<String> {
        let columns = self.inputs.iter().zip(&self.input_scalers).zip(row);
        columns.filter(|((_, s), v)| s.is_outside(**v)).map(|((c, _), _)| c.name.clone()).collect()
    }

    /// Predicts many rows (flat, row by row).
    ///
    /// # Errors
    /// If `rows` is no whole number of rows or a value is not finite.
    pub fn predict_batch(&self, rows: &[f64]) -> Result<BatchPrediction, ModelError> {
        let columns = self.inputs.len();
        self.check_rows(rows)?;
        let mut values = vec![0.0; rows.len() / columns];
        let scalers =
            Scalers { inputs: &self.input_scalers, outputs: std::slice::from_ref(&self.output_scaler) };
        forward::batch(Isa::detect(), &self.network, Some(scalers), rows, &mut values);
        let is_outside = |row: &[f64]| row.iter().zip(&self.input_scalers).any(|(v, s)| s.is_outside(*v));
        Ok(BatchPrediction { values, outside: rows.chunks_exact(columns).map(is_outside).collect() })
    }

    /// Standard deviations of observations around the predictions of many rows (flat, row by row), in the unit of the
    /// output; none if the model was trained without Bayesian regularisation. Where it was trained on several blocks (runs),
    /// [`Intervals`] widens or narrows them to what blocks that are left out are off by.
    ///
    /// The first call factorises the curvature over the training rows, later ones use it.
    ///
    /// # Errors
    /// As [`Model::predict_batch`].
    pub fn standard_deviations(&self, rows: &[f64]) -> Result<Option<Vec<f64>>, ModelError> {
        self.standard_deviations_of(rows, 1)
    }

    /// As [`Model::standard_deviations`] for the means over so many rows that follow each other, the points of one
    /// observation, see [`Data::with_points`]: one number an observation.
    ///
    /// # Errors
    /// As [`Model::predict_batch`], and if `rows` is no whole number of observations.
    pub fn standard_deviations_of(
        &self,
        rows: &[f64],
        points: usize,
    ) -> Result<Option<Vec<f64>>, ModelError> {
        self.check_rows(rows)?;
        if points == 0 || !(rows.len() / self.inputs.len()).is_multiple_of(points) {
            let found = rows.len() / self.inputs.len();
            return Err(ModelError::Columns(format!(
                "{found} rows are no whole number of observations of {points} points"
            )));
        }
        let laplace = self.laplace.get_or_init(|| {
            let (rows, evidence) = (self.training_rows.as_ref()?, self.fit.evidence?);
            Laplace::new(Isa::detect(), &self.network, rows, evidence)
        });
        let Some(laplace) = laplace else { return Ok(None) };
        let scalers = &self.input_scalers;
        let scaled = rows.iter().enumerate().map(|(i, v)| scalers[i % scalers.len()].scale(*v)).collect();
        let unit = self.output_scaler.inverse_factor();
        let variances = laplace.variances(&self.network, scaled, points);
        let factors: Vec<f64> = match &self.fit.intervals {
            None => vec![1.0; variances.len()],
            Some(intervals) => {
                let column =
                    self.inputs.iter().position(|input| Some(&input.name) == intervals.input.as_ref());
                let first_points = rows.chunks(points * self.inputs.len());
                first_points.map(|row| intervals.factor(column.map_or(0.0, |column| row[column]))).collect()
            }
        };
        Ok(Some(variances.iter().zip(&factors).map(|(v, c)| c * v.sqrt() * unit).collect()))
    }

    /// Writes the model beside `path` and renames it there.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ModelError> {
        model_file::save(self, path)
    }

    /// Reads a model.
    ///
    /// # Errors
    /// If the file cannot be read, is truncated or altered, was written by a newer version, or is no model.
    pub fn load(path: &Path) -> Result<Model, ModelError> {
        model_file::load(path)
    }

    /// The text of the file that [`Model::save`] writes.
    pub fn to_json(&self) -> String {
        model_file::to_json(self)
    }

    /// A model from the text of its file; `name` is what messages call it.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_json(text: &str, name: &str) -> Result<Model, ModelError> {
        model_file::from_json(text, name)
    }

    fn row_length(&self, given: usize) -> ModelError {
        let names: Vec<&str> = self.inputs.iter().map(|c| c.name.as_str()).collect();
        ModelError::RowLength { expected: self.inputs.len(), names: names.join(", "), given }
    }

    fn check_rows(&self, rows: &[f64]) -> Result<(), ModelError> {
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

/// The rows in the network's units.
fn scale(data: &Data, inputs: &[Scaler], output: &Scaler) -> Data {
    Data {
        inputs: data.inputs.iter().enumerate().map(|(i, v)| inputs[i % inputs.len()].scale(*v)).collect(),
        targets: data.targets.iter().map(|v| output.scale(*v)).collect(),
        validation: data.validation().map(|v| Box::new(scale(v, inputs, output))),
        weights: data.weights.clone(),
        blocks: data.blocks.clone(),
        ..*data
    }
}
