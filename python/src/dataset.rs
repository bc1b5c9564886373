//! Data sets: the states of runs, from which surrogates learn.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use granum::Registry;
use granum_campaign::data_set::DataSet;
use granum_learn::{RunStates, Split};
use granum_run::record::read_record;
use pyo3::exceptions::{PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PyType};

use crate::arrays::{self, Array};
use crate::detached::detached;
use crate::errors;
use crate::quantity;
use crate::results::Place;
use crate::run::Run;
use crate::table::{self, Table};

/// Largest stride of training states.
const LARGEST_STRIDE: u64 = 1 << 32;

/// The states of runs, from which surrogates learn: a column for each quantity, a row for each state of each run. Keys of the case and
/// measures of the sample are columns as well, the same in all rows of a run.
///
/// `runs` are runs of granum, folders of runs or tables with a row for each state, or a mapping of names to them.
#[pyclass(frozen, module = "granum")]
pub struct Dataset {
    pub inner: Arc<granum_learn::Dataset>,
}

impl Dataset {
    fn new(dataset: granum_learn::Dataset) -> Dataset {
        Dataset { inner: Arc::new(dataset) }
    }

    fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.inner.runs().iter().map(RunStates::name)
    }
}

/// The run in a folder as states of a run of this name.
fn of_folder(name: &str, folder: &Path) -> granum_learn::Result<RunStates> {
    let run = Registry::standard().run_at(folder)?;
    RunStates::of_case(name, &run.case()?, read_record(&run)?)
}

/// A run, the folder of one, or a table with a row for each state.
fn states_of(name: &str, value: &Bound<'_, PyAny>) -> PyResult<RunStates> {
    let py = value.py();
    let failed = |error| errors::of_learning(py, &error);
    if let Ok(table) = value.cast::<Table>() {
        return RunStates::new(name, table.get().copied()).map_err(failed);
    }
    if let Ok(run) = value.cast::<Run>() {
        let place = run.get().place.clone();
        let states = detached(py, || match &*place {
            Place::Memory { case, result } => RunStates::of_case(name, case, result.record.clone()),
            Place::Folder { run, .. } => RunStates::of_case(name, &run.case()?, read_record(&run.now())?),
        })?;
        return states.map_err(failed);
    }
    let Ok(folder) = value.extract::<PathBuf>() else {
        let kind = value.get_type().name()?;
        let message =
            format!("{name}: a run of a data set is a granum.Run, its folder or a granum.Table, not {kind}");
        return Err(PyTypeError::new_err(message));
    };
    detached(py, || of_folder(name, &folder))?.map_err(failed)
}

/// The name of a run that has none of its own: that of its folder, else its number.
fn name_of(value: &Bound<'_, PyAny>, number: usize) -> String {
    let folder = match value.cast::<Run>() {
        Ok(run) => run.get().folder().map(Path::to_path_buf),
        Err(_) => value.extract::<PathBuf>().ok(),
    };
    let name = folder.and_then(|folder| Some(folder.file_name()?.to_string_lossy().into_owned()));
    name.unwrap_or_else(|| format!("run-{}", number + 1))
}

#[pymethods]
impl Dataset {
    #[new]
    fn of_runs(py: Python<'_>, runs: &Bound<'_, PyAny>) -> PyResult<Dataset> {
        // A text is a sequence too, of letters.
        if runs.extract::<PathBuf>().is_ok() {
            let message = "runs: a data set is made of a list of runs; granum.Dataset.read(folder) reads that of a campaign or one in a folder";
            return Err(PyTypeError::new_err(message));
        }
        let mut states = Vec::new();
        if let Ok(named) = runs.cast::<PyMapping>() {
            for item in named.items()?.iter() {
                let (name, run): (String, Bound<'_, PyAny>) = item.extract()?;
                states.push(states_of(&name, &run)?);
            }
        } else {
            for (number, run) in runs.try_iter()?.enumerate() {
                let run = run?;
                states.push(states_of(&name_of(&run, number), &run)?);
            }
        }
        let dataset = granum_learn::Dataset::new(states);
        dataset.map(Dataset::new).map_err(|error| errors::of_learning(py, &error))
    }

    /// The data set of a campaign, or one in a folder of its own, whose files are compared with their sums.
    #[classmethod]
    fn read(_class: &Bound<'_, PyType>, py: Python<'_>, folder: PathBuf) -> PyResult<Dataset> {
        let read = || -> granum_learn::Result<granum_learn::Dataset> {
            let inside = DataSet::meant_by(&folder)?.ok_or_else(|| {
                let message = "is neither a data set nor a campaign; granum.Dataset([...]) takes single runs";
                granum_io::Error::content(&folder, message)
            })?;
            let runs = DataSet::read(&inside, Registry::standard().reading())?.each_run()?;
            let states = runs.into_iter().map(|run| RunStates::of_case(&run.name, &run.case, run.measured));
            granum_learn::Dataset::new(states.collect::<granum_learn::Result<_>>()?)
        };
        detached(py, read)?.map(Dataset::new).map_err(|error| errors::of_learning(py, &error))
    }

    /// The names of the runs.
    #[getter]
    fn runs(&self) -> Vec<&str> {
        self.names().collect()
    }

    /// The names of the columns of numbers that all runs have.
    #[getter]
    fn columns(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let inner = self.inner.clone();
        let variables = detached(py, move || inner.variables())?;
        Ok(variables.into_iter().map(|variable| variable.name).collect())
    }

    /// The names of the columns.
    fn keys(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.columns(py)
    }

    /// The SI unit of each of them; an empty text for a pure number.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        for variable in self.inner.variables() {
            units.set_item(variable.name, variable.unit)?;
        }
        Ok(units)
    }

    /// What has words instead of numbers, such as `contact.normal`, with its words.
    #[getter]
    fn categories<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for category in self.inner.categories() {
            let words: Vec<String> =
                category.columns().filter_map(|column| Some(column.split_once('=')?.1.to_string())).collect();
            found.set_item(category.name, words)?;
        }
        Ok(found)
    }

    /// The number of the run of each row, from 0: the groups of a cross-validation that leaves out whole runs.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let groups: Vec<i64> = self.inner.run_of_rows().into_iter().map(|run| run as i64).collect();
        let rows = groups.len();
        arrays::integers(py, groups, vec![rows])
    }

    /// SHA-256 of names, units and the bits of all numbers.
    #[getter]
    fn digest(&self, py: Python<'_>) -> PyResult<String> {
        let inner = self.inner.clone();
        detached(py, move || inner.digest())
    }

    /// The values of columns, a row for each state; names as for `expand`.
    fn values<'py>(&self, py: Python<'py>, names: &Bound<'py, PyAny>) -> PyResult<Array<'py>> {
        let names = words("names", names)?;
        let inner = self.inner.clone();
        let found = detached(py, move || {
            let names = inner.expand(&names)?;
            Ok((inner.values(&names)?, names.len()))
        })?;
        let (values, columns) = found.map_err(|error| errors::of_learning(py, &error))?;
        arrays::reals(py, values, vec![self.inner.rows(), columns])
    }

    /// The values of columns as a tensor of torch, which has the memory of the array of `values` and no copy of it, and as that array must
    /// not be written to. Needs torch.
    fn tensor<'py>(slf: &Bound<'py, Self>, names: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let values = slf.call_method1("values", (names,))?;
        slf.py().import("granum._frames")?.call_method1("to_torch", (values,))
    }

    /// The columns that names stand for: that of a histogram for its bins, that of a category for a column of each word.
    fn expand(&self, py: Python<'_>, names: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
        let names = words("names", names)?;
        self.inner.expand(&names).map_err(|error| errors::of_learning(py, &error))
    }

    /// All rows as a table, with the number of the run, from 1, in the column `run`.
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let inner = self.inner.clone();
        let found = detached(py, move || inner.table())?;
        table::object(py, found.map_err(|error| errors::of_learning(py, &error))?)
    }

    /// The runs as a table with their parameters, a row for each.
    fn runs_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = self.inner.runs_table().map_err(|error| errors::of_learning(py, &error))?;
        table::object(py, found)
    }

    /// The data set of some of the runs.
    #[pyo3(signature = (runs))]
    fn select(&self, py: Python<'_>, runs: &Bound<'_, PyAny>) -> PyResult<Dataset> {
        let runs = words("runs", runs)?;
        if let Some(unknown) = runs.iter().find(|run| !self.names().any(|name| name == *run)) {
            return Err(errors::of_key("the data set has no run", unknown, self.names()));
        }
        let chosen = self.inner.select(|run, _| runs.iter().any(|name| name == run.name()));
        match chosen.runs().is_empty() {
            true => Err(errors::general(py, "a data set has at least one run")),
            false => Ok(Dataset::new(chosen)),
        }
    }

    /// Parts for training and for judging: `unseen` runs; of the others every second (`stride`) state as `training` and the rest as
    /// `held_out`, and all their states as `training_runs`, for methods with memory. A part without states is `None`.
    #[pyo3(signature = (*, unseen=None, stride=None, first_state=0))]
    fn split<'py>(
        &self,
        py: Python<'py>,
        unseen: Option<&Bound<'py, PyAny>>,
        stride: Option<&Bound<'py, PyAny>>,
        first_state: u64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let unseen = unseen.map_or(Ok(Vec::new()), |names| words("unseen", names))?;
        let mut split = Split::default().first_state(first_state).unseen(unseen);
        if let Some(stride) = stride {
            split = split.stride(quantity::whole("stride", stride, 1, LARGEST_STRIDE)? as usize);
        }
        let inner = self.inner.clone();
        let parts = detached(py, move || inner.split(&split))?;
        let parts = parts.map_err(|error| errors::of_learning(py, &error))?;
        let found = PyDict::new(py);
        let named = [
            ("training", parts.training),
            ("training_runs", parts.training_runs),
            ("held_out", parts.held_out),
            ("unseen", parts.unseen),
        ];
        for (name, part) in named {
            let is_empty = part.runs().is_empty();
            found.set_item(name, (!is_empty).then(|| Dataset::new(part)))?;
        }
        Ok(found)
    }

    fn __len__(&self) -> usize {
        self.inner.rows()
    }

    fn __contains__(&self, name: &Bound<'_, PyAny>) -> bool {
        name.extract::<String>().is_ok_and(|name| self.inner.variable(&name).is_ok())
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: String) -> PyResult<Array<'py>> {
        let inner = self.inner.clone();
        match detached(py, move || inner.column(&name))? {
            Ok(values) => {
                let rows = values.len();
                arrays::reals(py, values, vec![rows])
            }
            Err(error) => Err(PyKeyError::new_err(error.to_string())),
        }
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pyo3::types::PyList::new(py, self.columns(py)?)?.try_iter()?.into_any())
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Dataset>().is_ok_and(|other| other.get().inner == self.inner)
    }

    #[classattr]
    fn __hash__(py: Python<'_>) -> Py<PyAny> {
        py.None()
    }

    /// What a notebook shows.
    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        slf.py().import("granum._plots")?.call_method1("of_dataset", (slf,))?.extract()
    }

    fn __repr__(&self) -> String {
        format!("<granum.Dataset of {} states of {} runs>", self.inner.rows(), self.inner.runs().len())
    }
}

/// A name, or a sequence of names.
pub fn words(what: &str, names: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if let Ok(name) = names.extract::<String>() {
        return Ok(vec![name]);
    }
    let wrong = || PyTypeError::new_err(format!("{what}: a name or a list of names is needed"));
    let each = names.try_iter().map_err(|_| wrong())?;
    each.map(|name| name?.extract().map_err(|_| wrong())).collect()
}
