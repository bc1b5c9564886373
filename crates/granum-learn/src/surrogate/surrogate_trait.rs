//! The traits of surrogates and of the methods that fit them.

use std::any::Any;
use std::sync::Arc;

use granum_core::observer::{Flow, Observer, Progress};
use granum_core::quantity::format_number;

use super::content::Content;
use super::possible_values::{cut_to_possible, possible_values};
use super::prediction::{Estimate, Prediction};
use super::run_inputs::RunInputs;
use super::run_steps::RunSteps;
use super::spec::{Columns, FitSpec};
use crate::dataset::{Dataset, Variable};
use crate::error::{LearnError, Result};
use crate::methods::networks::{NetworkCheckpoints, NetworkSettings};
use crate::onnx::{self, OnnxAnswer, OnnxGraph, Value};

/// A method of fitting surrogates; the documentation of [this module](super) contains a complete example.
pub trait SurrogateMethod: Send + Sync {
    /// Name of the method in files and messages.
    fn name(&self) -> &str;

    /// A short description.
    fn help(&self) -> &str;

    /// True if a prediction depends on the states of a run before the present one. Such a method is fitted to all states of
    /// its runs, and not to every second one.
    fn has_memory(&self) -> bool {
        false
    }

    /// Fits a surrogate to all rows of a data set. The result depends only on the data set and the spec, and is
    /// bit-identical for any number of threads. A fit that takes long reports its progress to the observer, which can stop
    /// it.
    ///
    /// # Errors
    /// If columns are missing, values are not finite, or there are too few rows; [`LearnError::Stopped`] if the observer
    /// stopped the fit.
    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>>;

    /// As [`SurrogateMethod::fit`], for a fit of networks that can be resumed: each network is kept when it is trained, and the
    /// state of an unfinished one at intervals. A method without networks keeps nothing.
    ///
    /// # Errors
    /// As [`SurrogateMethod::fit`].
    fn fit_resumable(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
        checkpoints: &dyn NetworkCheckpoints,
    ) -> Result<Box<dyn Surrogate>> {
        let _ = checkpoints;
        self.fit(dataset, spec, observer)
    }

    /// The same method with other settings of its networks; `None` if they are not settings of this method.
    ///
    /// # Errors
    /// If there is no trainer of the given name.
    fn with_networks(&self, settings: &NetworkSettings) -> Result<Option<Arc<dyn SurrogateMethod>>> {
        let _ = settings;
        Ok(None)
    }

    /// Refuses training states to which it cannot be fitted, before anything is fitted.
    ///
    /// # Errors
    /// If it cannot be fitted; the message gives the reason.
    fn check(&self, dataset: &Dataset, spec: &FitSpec) -> Result<()> {
        let _ = (dataset, spec);
        Ok(())
    }

    /// Recreates a surrogate from the result of [`Surrogate::content`].
    ///
    /// # Errors
    /// If the content is not that of such a surrogate with these columns; the message gives the reason.
    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>>;
}

/// Reports to the observer that the next of some outputs is fitted, for a method that fits one after the other.
///
/// # Errors
/// [`LearnError::Stopped`] if the observer requests the end.
pub(crate) fn report_output(observer: &mut dyn Observer, outputs: &[Variable], done: usize) -> Result<()> {
    let total = outputs.len();
    let progress = Progress::new("training", "outputs", done as u64).out_of(total as u64);
    let progress = match outputs.get(done) {
        Some(output) => progress.part(&output.name),
        None => progress,
    };
    match observer.progress(&progress) {
        Flow::Continue => Ok(()),
        Flow::Stop => Err(LearnError::Stopped { done, total }),
    }
}

/// A fitted model, which predicts outputs from inputs. The documentation of [this module](super) contains a complete example.
pub trait Surrogate: Any + Send + Sync {
    /// Name of the method with which it was fitted and by which it is loaded.
    fn method(&self) -> &str;

    /// The inputs and outputs.
    fn columns(&self) -> &Columns;

    /// True if a prediction depends on the states of a run before the present one, as [`SurrogateMethod::has_memory`].
    fn has_memory(&self) -> bool {
        false
    }

    /// Predicts the states of runs, each with a finite value for every input in order, which [`Surrogate::predict`] ensures.
    /// A surrogate without memory predicts [`RunInputs::rows`], one with memory [`RunInputs::runs`]. The intervals should
    /// contain the given share (0 to 1) of the observations of new runs.
    ///
    /// # Errors
    /// If a row cannot be predicted.
    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>>;

    /// For a surrogate with memory a run whose states come one after the other, with intervals of a level, which owns what it needs; `None` for one without, and for one that can
    /// only predict whole runs.
    ///
    /// # Errors
    /// If the surrogate cannot be evaluated.
    fn steps(&self, level: f64) -> Result<Option<Box<dyn RunSteps>>> {
        let _ = level;
        Ok(None)
    }

    /// Adds all that it predicts to the graph of an ONNX file, with intervals of a level: inputs and outputs in physical units under the names of its
    /// columns, see [`crate::onnx::to_bytes`].
    ///
    /// # Errors
    /// If it has no ONNX form, with the reason.
    fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        let inputs = onnx::inputs(graph, self.columns());
        let answer = self.onnx_answer(graph, &inputs, level)?;
        onnx::state_ranges(graph, self.columns(), &answer.ranges);
        let outputs = 0..self.columns().outputs.len();
        let possible: Vec<[f64; 2]> = outputs.map(|output| self.possible_values(output)).collect();
        onnx::outputs_within(graph, self.columns(), &answer.estimates, &answer.outside, &possible);
        Ok(())
    }

    /// What it predicts for a table of a graph with a column for each input, for a surrogate without memory. [`Surrogate::onnx`] gives the answer as outputs,
    /// and a surrogate that is made of others can go on from theirs.
    ///
    /// # Errors
    /// As [`Surrogate::onnx`].
    fn onnx_answer(&self, graph: &mut OnnxGraph, inputs: &Value, level: f64) -> Result<OnnxAnswer> {
        let _ = (graph, inputs, level);
        Err(onnx::refused(self.method()))
    }

    /// Refuses a data set with the columns of its names that mean something else, such as bins of another width.
    ///
    /// # Errors
    /// If there is such a column.
    fn check(&self, dataset: &Dataset) -> Result<()> {
        let _ = dataset;
        Ok(())
    }

    /// The means of [`Surrogate::evaluate`], with the same bits: for methods that give them in less time than intervals.
    ///
    /// # Errors
    /// As [`Surrogate::evaluate`].
    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let means = |prediction: Prediction| prediction.values.iter().map(|estimate| estimate.mean).collect();
        Ok(self.evaluate(inputs, 0.5)?.into_iter().map(means).collect())
    }

    /// The means of the predictions alone, which networks, regressions, trees and cascades give in less time than intervals.
    ///
    /// # Errors
    /// As [`Surrogate::predict`].
    fn means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        check_inputs(self.method(), self.columns(), inputs)?;
        let means = self.evaluate_means(inputs)?;
        check_answer(self.method(), self.columns(), inputs, means.iter().map(Vec::len))?;
        Ok(means)
    }

    /// Everything that is needed for bit-identical predictions after loading.
    ///
    /// # Errors
    /// If the content cannot be represented in JSON.
    fn content(&self) -> Result<Content>;

    /// Predicts all states of runs. Intervals are cut to the values that a quantity can have (see [`possible_values`](super::possible_values)).
    ///
    /// # Errors
    /// If the rows do not have a value for every input, a value is not finite, or the level is not between 0 and 1.
    fn predict(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        check_level(self.method(), level)?;
        check_inputs(self.method(), self.columns(), inputs)?;
        let predictions = self.evaluate(inputs, level)?;
        let values = predictions.iter().map(|prediction| prediction.values.len());
        check_answer(self.method(), self.columns(), inputs, values)?;
        Ok(cut_to_possible(predictions, |output| self.possible_values(output)))
    }

    /// The range of the values that an output, given by its number, can have; by default what its name says ([`possible_values`](super::possible_values)).
    fn possible_values(&self, output: usize) -> [f64; 2] {
        self.columns()
            .outputs
            .get(output)
            .map_or([f64::NEG_INFINITY, f64::INFINITY], |own| possible_values(&own.name))
    }

    /// Predicts rows, given in row-major order with a value for every input in order. For a surrogate with memory, each row
    /// is the first state of a run of its own.
    ///
    /// # Errors
    /// As [`Surrogate::predict`], and if `rows` does not contain a whole number of rows, or an answer is not a finite number.
    fn predict_rows(&self, rows: &[f64], level: f64) -> Result<Vec<Prediction>> {
        let names = self.columns().input_names();
        let inputs = RunInputs::separate(rows.to_vec(), names.len()).map_err(|_| {
            let (needed, list, found) = (names.len(), names.join(", "), rows.len());
            let reason =
                format!("a row has {needed} values ({list}); {found} values are not a whole number of rows");
            LearnError::Surrogate { method: self.method().into(), reason }
        })?;
        let predictions = self.predict(&inputs, level)?;
        check_finite(self.method(), self.columns(), &inputs, &predictions)?;
        Ok(predictions)
    }
}

/// Refuses a level that is no share.
pub(crate) fn check_level(method: &str, level: f64) -> Result<()> {
    if level > 0.0 && level < 1.0 {
        return Ok(());
    }
    let reason = format!("the level of an interval must be between 0 and 1, not {level}");
    Err(LearnError::Surrogate { method: method.into(), reason })
}

/// Refuses rows that do not have a finite value for every input.
pub(crate) fn check_inputs(method: &str, columns: &Columns, inputs: &RunInputs) -> Result<()> {
    let problem = |reason: String| Err(LearnError::Surrogate { method: method.into(), reason });
    let names = columns.input_names();
    if names.len() != inputs.columns() {
        let (needed, list, found) = (names.len(), names.join(", "), inputs.columns());
        return problem(format!("a row has {needed} values ({list}), not {found}"));
    }
    if let Some(k) = inputs.values().iter().position(|value| !value.is_finite()) {
        let (row, name, value) = (k / names.len() + 1, &names[k % names.len()], inputs.values()[k]);
        return problem(format!("row {row}: {name} is {value}, not a finite number"));
    }
    Ok(())
}

/// Refuses predictions that are not finite numbers, as they may be far outside of what a surrogate was fitted to: they are no answer.
///
/// # Errors
/// With the row, the output and the inputs outside of their ranges, or all of them.
pub(crate) fn check_finite(
    method: &str,
    columns: &Columns,
    inputs: &RunInputs,
    predictions: &[Prediction],
) -> Result<()> {
    let names = columns.input_names();
    for (row, prediction) in predictions.iter().enumerate() {
        let is_finite = |estimate: &Estimate| {
            let interval = estimate.interval.as_ref();
            let ends = interval.map_or([0.0; 2], |interval| [interval.lower, interval.upper]);
            estimate.mean.is_finite() && ends.iter().all(|end| end.is_finite())
        };
        let Some(output) = prediction.values.iter().position(|estimate| !is_finite(estimate)) else {
            continue;
        };
        let output = columns.outputs.get(output).map_or("", |output| output.name.as_str());
        let far = prediction.outside.iter().map(|outside| {
            let [value, low, high] = [outside.value, outside.range[0], outside.range[1]].map(format_number);
            format!("{} = {value} (fitted from {low} to {high})", outside.name)
        });
        let mut said: Vec<String> = far.collect();
        if said.is_empty() {
            let values = inputs.values().chunks(names.len().max(1)).nth(row).unwrap_or_default();
            said = names
                .iter()
                .zip(values)
                .map(|(name, value)| format!("{name} = {}", format_number(*value)))
                .collect();
        }
        return Err(LearnError::Surrogate {
            method: method.into(),
            reason: format!(
                "row {}: it has no finite value of {output} at {}: that is too far from what it was fitted to",
                row + 1,
                said.join(", ")
            ),
        });
    }
    Ok(())
}

/// Refuses an answer that does not have a value of every output for every row.
fn check_answer(
    method: &str,
    columns: &Columns,
    inputs: &RunInputs,
    mut values: impl ExactSizeIterator<Item = usize>,
) -> Result<()> {
    let (rows, outputs) = (inputs.len(), columns.outputs.len());
    if values.len() == rows && values.all(|count| count == outputs) {
        return Ok(());
    }
    let reason = format!("it did not return {rows} rows with {outputs} values each");
    Err(LearnError::Surrogate { method: method.into(), reason })
}
