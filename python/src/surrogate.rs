//! Surrogates that are fitted to data sets.

use std::path::PathBuf;
use std::sync::Arc;

use granum::Registry;
use granum_learn::networks::NetworkSettings;
use granum_learn::surrogate::{Columns, RunInputs, save, to_json};
use granum_learn::{FitSpec, LearnError, Prediction, score_surrogate};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};

use crate::arrays::{self, Array};
use crate::dataset::{Dataset, words};
use crate::detached::detached;
use crate::errors;
use crate::quantity;
use crate::table::{Table, columns_of};
use crate::watch::{self, Watch, serialised};

/// Most threads of a fit, most neurons of a layer, and largest seed.
const MOST_THREADS: u64 = 4096;
const MOST_NEURONS: u64 = 1000;
const LARGEST_SEED: u64 = 1 << 53;
/// Rows that a method without memory predicts at once. What it has of each row is released before the next ones, which takes less time than
/// to keep all of a million rows.
const ROWS_AT_ONCE: usize = 1 << 14;

/// A surrogate: `granum.surrogates.fit` fits it, `granum.surrogates.read` reads it.
#[pyclass(frozen, module = "granum.surrogates")]
pub struct Surrogate {
    inner: Arc<dyn granum_learn::Surrogate>,
}

/// The methods by which surrogates are fitted, with what they are.
#[pyfunction]
pub fn methods(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    for method in Registry::standard().methods.all() {
        found.set_item(method.name(), method.help())?;
    }
    Ok(found)
}

/// Fits a surrogate to all states of a data set; `methods()` lists the methods.
///
/// `inputs` and `outputs` are columns, with the rules of `Dataset.expand`. `coordinate` is the input along which a test runs. `hidden` are
/// the numbers of neurons of the hidden layers of networks. The result depends on the data set and `seed` (1), not on `threads`.
/// `on_progress` is called as in `granum.run`.
#[pyfunction]
#[pyo3(signature = (dataset, inputs, outputs, *, method="feed-forward", coordinate=None, seed=None, hidden=None, threads=None, on_progress=None))]
pub fn fit(
    py: Python<'_>,
    dataset: &Bound<'_, Dataset>,
    inputs: &Bound<'_, PyAny>,
    outputs: &Bound<'_, PyAny>,
    method: &str,
    coordinate: Option<String>,
    seed: Option<&Bound<'_, PyAny>>,
    hidden: Option<Vec<Bound<'_, PyAny>>>,
    threads: Option<&Bound<'_, PyAny>>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Surrogate> {
    let failed = |error: &granum_learn::LearnError| errors::of_learning(py, error);
    let (mut inputs, outputs) = (words("inputs", inputs)?, words("outputs", outputs)?);
    if let Some(coordinate) = coordinate.as_ref().filter(|name| !inputs.contains(name)) {
        inputs.insert(0, coordinate.clone());
    }
    let mut spec = FitSpec::new(inputs, outputs);
    spec.coordinate = coordinate;
    if let Some(seed) = seed {
        spec.seed = quantity::whole("seed", seed, 0, LARGEST_SEED)?;
    }
    if let Some(threads) = threads {
        spec.threads = quantity::whole("threads", threads, 1, MOST_THREADS)? as usize;
    }
    let mut methods = Registry::standard().methods;
    if let Some(hidden) = hidden {
        let neurons = |count: &Bound<'_, PyAny>| quantity::whole("hidden", count, 1, MOST_NEURONS);
        let hidden: PyResult<Vec<usize>> =
            hidden.iter().map(|count| neurons(count).map(|count| count as usize)).collect();
        let settings = NetworkSettings { hidden: hidden?, ..NetworkSettings::default() };
        methods = methods.with_networks(&settings).map_err(|error| failed(&error))?;
    }
    let chosen = methods.by_name(method).map_err(|error| failed(&error))?;
    let (dataset, mut watch) = (dataset.get().inner.clone(), Watch::new(None, on_progress));
    let fitted = detached(py, || {
        chosen.check(&dataset, &spec)?;
        chosen.fit(&dataset, &spec, &mut watch)
    })?;
    let inner = watch::told(py, watch, fitted, failed)?;
    Ok(Surrogate { inner: Arc::from(inner) })
}

/// The inputs that a user gives: a data set, a table or what is like one, or an array with a row for each state.
fn inputs_of(
    data: &Bound<'_, PyAny>,
    columns: &Columns,
    runs: Option<&Bound<'_, PyAny>>,
) -> PyResult<RunInputs> {
    let py = data.py();
    let failed = |error| errors::of_learning(py, &error);
    if let Ok(dataset) = data.cast::<Dataset>() {
        let dataset = dataset.get().inner.clone();
        return detached(py, || RunInputs::from_dataset(&dataset, columns))?.map_err(failed);
    }
    let names = columns.input_names();
    let (values, rows) = match data.cast::<Table>() {
        Ok(table) => by_column(py, &names, |name| table.get().__getitem__(py, name))?,
        Err(_) => match columns_of(data)? {
            Some(given) => by_column(py, &names, |name| {
                let found = given.iter().find(|(known, _)| known == name).map(|(_, values)| values.clone());
                found.ok_or_else(|| {
                    errors::of_key(
                        "the inputs have no column",
                        name,
                        given.iter().map(|(name, _)| name.as_str()),
                    )
                })
            })?,
            None => by_row(data, &names)?,
        },
    };
    let lengths = match runs {
        None => vec![1; rows],
        Some(runs) => {
            let (runs, shape) = arrays::numbers("runs", runs)?;
            if shape != [rows] {
                let message = format!("there are {rows} rows, and the runs have the shape {shape:?}");
                return Err(errors::of_value(py, "runs", format!("{shape:?}"), message));
            }
            runs.chunk_by(|a, b| a == b).map(<[f64]>::len).collect()
        }
    };
    RunInputs::new(values, names.len(), lengths).map_err(failed)
}

/// The values of columns in row-major order, with their number of rows.
fn by_column<'py>(
    py: Python<'py>,
    names: &[String],
    column: impl Fn(&str) -> PyResult<Bound<'py, PyAny>>,
) -> PyResult<(Vec<f64>, usize)> {
    let mut columns = Vec::new();
    for name in names {
        let (values, shape) = arrays::numbers(name, &column(name)?)?;
        arrays::check_finite(py, name, &values, &shape)?;
        columns.push(values);
    }
    let rows = columns.first().map_or(0, Vec::len);
    if let Some(other) = columns.iter().position(|column| column.len() != rows) {
        let message = format!("it has {} rows, and {} has {rows}", columns[other].len(), names[0]);
        return Err(errors::of_value(py, &names[other], "", message));
    }
    let values =
        py.detach(|| (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect());
    Ok((values, rows))
}

/// The values of an array with a row for each state and a column for each input.
fn by_row(data: &Bound<'_, PyAny>, names: &[String]) -> PyResult<(Vec<f64>, usize)> {
    let (values, shape) = arrays::numbers("inputs", data)?;
    let [rows, columns] = shape[..] else {
        let message = format!(
            "rows of {} values are needed ({}), and the shape is {shape:?}",
            names.len(),
            names.join(", ")
        );
        return Err(errors::of_value(data.py(), "inputs", format!("{shape:?}"), message));
    };
    if columns != names.len() {
        let message = format!("a row has {} values ({}), not {columns}", names.len(), names.join(", "));
        return Err(errors::of_value(data.py(), "inputs", format!("{shape:?}"), message));
    }
    arrays::check_finite(data.py(), "inputs", &values, &shape)?;
    Ok((values, rows))
}

/// The estimates of one output.
#[derive(Default)]
struct Estimates {
    mean: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    deviation: Vec<f64>,
}

impl Estimates {
    /// Adds those of the output of this number; the ends and the deviation are NaN for an estimate without an interval.
    fn extend(&mut self, predictions: &[Prediction], output: usize) {
        for estimate in predictions.iter().filter_map(|prediction| prediction.values.get(output)) {
            let interval = estimate.interval.as_ref();
            self.mean.push(estimate.mean);
            self.lower.push(interval.map_or(f64::NAN, |interval| interval.lower));
            self.upper.push(interval.map_or(f64::NAN, |interval| interval.upper));
            self.deviation.push(interval.map_or(f64::NAN, |interval| interval.standard_deviation()));
        }
    }

    fn object<'py>(self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for (name, values) in [
            ("mean", self.mean),
            ("lower", self.lower),
            ("upper", self.upper),
            ("standard_deviation", self.deviation),
        ] {
            let rows = values.len();
            found.set_item(name, arrays::reals(py, values, vec![rows])?)?;
        }
        Ok(found)
    }
}

impl Surrogate {
    /// What is in it.
    pub fn shared(&self) -> Arc<dyn granum_learn::Surrogate> {
        Arc::clone(&self.inner)
    }

    /// The surrogate of a file.
    ///
    /// # Errors
    /// `granum.Error` with the file.
    pub fn of_file(py: Python<'_>, path: PathBuf) -> PyResult<Arc<dyn granum_learn::Surrogate>> {
        let read = detached(py, || Registry::standard().methods.load(&path))?;
        Ok(Arc::from(read.map_err(|error| errors::of_learning(py, &error))?))
    }

    /// Predicts rows piece after piece, or all at once by a method with memory.
    fn in_pieces(
        &self,
        inputs: RunInputs,
        mut predict: impl FnMut(&RunInputs) -> granum_learn::Result<()>,
    ) -> granum_learn::Result<()> {
        if self.inner.has_memory() || inputs.len() <= ROWS_AT_ONCE {
            return predict(&inputs);
        }
        let columns = inputs.columns();
        for rows in inputs.values().chunks(ROWS_AT_ONCE * columns) {
            predict(&RunInputs::separate(rows.to_vec(), columns)?)?;
        }
        Ok(())
    }

    /// The estimates of each output, and whether each row is outside of the range of the training.
    fn estimates(&self, inputs: RunInputs, level: f64) -> granum_learn::Result<(Vec<Estimates>, Vec<bool>)> {
        let outputs = self.inner.columns().outputs.len();
        let mut found: Vec<Estimates> = (0..outputs).map(|_| Estimates::default()).collect();
        let mut outside = Vec::with_capacity(inputs.len());
        self.in_pieces(inputs, |inputs| {
            let predictions = self.inner.predict(inputs, level)?;
            found.iter_mut().enumerate().for_each(|(output, of)| of.extend(&predictions, output));
            outside.extend(predictions.iter().map(Prediction::is_extrapolated));
            Ok(())
        })?;
        Ok((found, outside))
    }
}

#[pymethods]
impl Surrogate {
    /// The surrogate of a file.
    #[classmethod]
    fn read(_class: &Bound<'_, PyType>, py: Python<'_>, path: PathBuf) -> PyResult<Surrogate> {
        Ok(Surrogate { inner: Surrogate::of_file(py, path)? })
    }

    /// The surrogate of the text of such a file.
    #[classmethod]
    fn from_json(_class: &Bound<'_, PyType>, py: Python<'_>, text: &str) -> PyResult<Surrogate> {
        let read = detached(py, || Registry::standard().methods.from_json(text, "surrogate"))?;
        let inner = read.map_err(|error| errors::of_learning(py, &error))?;
        Ok(Surrogate { inner: Arc::from(inner) })
    }

    /// The text of its file.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || to_json(self.inner.as_ref()))?.map_err(|error| errors::of_learning(py, &error))
    }

    /// Writes its file, from which the program predicts as well.
    #[pyo3(signature = (path, *, force=false))]
    fn write(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let written = detached(py, || -> granum_learn::Result<()> {
            granum_io::check_output_file(&path, force)?;
            save(&path, self.inner.as_ref())
        })?;
        written.map_err(|error| errors::of_learning(py, &error))
    }

    /// Writes it as an ONNX file (opset 17), which other programs evaluate without granum.
    ///
    /// The inputs and outputs have the names of the columns, in physical units, as doubles with a row for each state: `predicted_NAME`, and where
    /// the surrogate provides them `standard_deviation_NAME`, `lower_NAME` and `upper_NAME`, and `outside`, which is 1 beyond the range of the
    /// training. A surrogate with memory is one step of it: `memory` is the `next_memory` of the state before, and where `begins` is 1 a run begins.
    /// `granum.Error` says which surrogates have no such form, and why.
    #[pyo3(signature = (path, *, level=0.9, force=false))]
    fn export_onnx(&self, py: Python<'_>, path: PathBuf, level: f64, force: bool) -> PyResult<()> {
        let written = detached(py, || -> granum_learn::Result<()> {
            granum_io::check_output_file(&path, force)?;
            granum_learn::onnx::save(&path, self.inner.as_ref(), level)
        })?;
        written.map_err(|error| errors::of_learning(py, &error))
    }

    /// The method by which it was fitted.
    #[getter]
    fn method(&self) -> &str {
        self.inner.method()
    }

    /// The names of the inputs in order.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        self.inner.columns().input_names()
    }

    /// The names of the outputs in order.
    #[getter]
    fn outputs(&self) -> Vec<String> {
        self.inner.columns().output_names()
    }

    /// The SI units of inputs and outputs.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        let columns = self.inner.columns();
        for variable in columns.inputs.iter().chain(&columns.outputs) {
            units.set_item(&variable.name, &variable.unit)?;
        }
        Ok(units)
    }

    /// True if a prediction depends on the states of a run before it.
    #[getter]
    fn has_memory(&self) -> bool {
        self.inner.has_memory()
    }

    /// Predicts states from a data set, from a table, dict or frame with the inputs as columns, or from an array of rows.
    ///
    /// The answer has `outputs`, with the `mean` of each, the ends `lower` and `upper` of the interval that should contain the share `level`
    /// of the observations of new runs, and the `standard_deviation` (NaN for a method without intervals); and `outside`, which is true
    /// for states beyond the range of the training. `runs` tells which run each row belongs to, for a surrogate with memory: rows with
    /// the same number that follow each other; without it each row is a run of its own.
    #[pyo3(signature = (inputs, *, level=0.9, runs=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyAny>,
        level: f64,
        runs: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let columns = self.inner.columns();
        let inputs = inputs_of(inputs, columns, runs)?;
        let found = detached(py, || self.estimates(inputs, level))?;
        let (estimates, outside) = found.map_err(|error| errors::of_learning(py, &error))?;
        let outputs = PyDict::new(py);
        for (variable, estimates) in columns.outputs.iter().zip(estimates) {
            outputs.set_item(&variable.name, estimates.object(py)?)?;
        }
        let answer = PyDict::new(py);
        answer.set_item("outputs", outputs)?;
        answer.set_item("outside", arrays::booleans(py, outside)?)?;
        answer.set_item("level", level)?;
        Ok(answer)
    }

    /// The means alone, which networks, regressions, trees and cascades give in less time: a row for each state, a column for each output.
    #[pyo3(signature = (inputs, *, runs=None))]
    fn means<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyAny>,
        runs: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Array<'py>> {
        let columns = self.inner.columns();
        let inputs = inputs_of(inputs, columns, runs)?;
        let rows = inputs.len();
        let means = detached(py, || {
            let mut means = Vec::with_capacity(rows * columns.outputs.len());
            self.in_pieces(inputs, |inputs| {
                means.extend(self.inner.means(inputs)?.into_iter().flatten());
                Ok(())
            })?;
            Ok(means)
        })?;
        arrays::reals(
            py,
            means.map_err(|error: LearnError| errors::of_learning(py, &error))?,
            vec![rows, columns.outputs.len()],
        )
    }

    /// How well it predicts a data set: `relative_rmse`, `r2`, `rmse` and the number of `states`.
    fn score<'py>(&self, py: Python<'py>, dataset: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let Ok(dataset) = dataset.cast::<Dataset>() else {
            return Err(PyTypeError::new_err("a surrogate is scored on a granum.Dataset"));
        };
        let dataset = dataset.get().inner.clone();
        let score = detached(py, || {
            self.inner.check(&dataset)?;
            score_surrogate(self.inner.as_ref(), &dataset)
        })?;
        serialised(py, &score.map_err(|error| errors::of_learning(py, &error))?)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_json")?, (slf.get().to_json(slf.py())?,)))
    }

    /// What a notebook shows.
    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        slf.py().import("granum._plots")?.call_method1("of_surrogate", (slf,))?.extract()
    }

    fn __repr__(&self) -> String {
        let (outputs, inputs) = (self.outputs().join(", "), self.inputs().join(", "));
        format!("<granum.surrogates.Surrogate {} of {outputs} from {inputs}>", self.method())
    }
}
