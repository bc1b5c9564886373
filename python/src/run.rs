//! Runs, in a folder or in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use granum_io::{RunKind, RunRecord};
use granum_run::{Laboratory, RunResult, digest};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tempfile::TempDir;

use crate::assembly::Assembly;
use crate::case::Case;
use crate::detached::detached;
use crate::errors;
use crate::report;
use crate::results::Place;
use crate::simulation::Simulation;
use crate::table::{self, SERIES, no_table};
use crate::values;
use crate::watch::serialised;

/// A run: a sample that `granum.prepare` made, or a test that `granum.run` carried out, in its folder or in memory.
#[pyclass(frozen, module = "granum")]
pub struct Run {
    pub place: Arc<Place>,
}

impl Run {
    pub fn in_folder(run: granum_io::Run, kept: Option<Arc<TempDir>>) -> Run {
        Run { place: Arc::new(Place::Folder { run, kept }) }
    }

    pub fn in_memory(case: granum_io::Case, result: RunResult) -> Run {
        Run { place: Arc::new(Place::Memory { case: Box::new(case), result: Box::new(result) }) }
    }

    /// What the run says about itself.
    fn about(&self, py: Python<'_>) -> PyResult<RunRecord> {
        match &*self.place {
            Place::Memory { result, .. } => Ok(result.about.clone()),
            Place::Folder { .. } => self.read(py, granum_io::Run::record),
        }
    }

    /// The folder of the run, if it has one.
    pub fn folder(&self) -> Option<&Path> {
        match &*self.place {
            Place::Folder { run, .. } => Some(run.path()),
            Place::Memory { .. } => None,
        }
    }

    /// What keeps its temporary folder, if it has one.
    pub fn kept(&self) -> Option<Arc<TempDir>> {
        match &*self.place {
            Place::Folder { kept, .. } => kept.clone(),
            Place::Memory { .. } => None,
        }
    }

    /// Reads something of the folder without Python's lock.
    fn read<T: Send>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&granum_io::Run) -> granum_io::Result<T> + Send,
    ) -> PyResult<T> {
        let Place::Folder { run, .. } = &*self.place else {
            return Err(errors::general(
                py,
                "the run is in memory and has no folder; give out=\"NAME\" when you run it",
            ));
        };
        detached(py, || read(run))?.map_err(|error| errors::of_file(py, &error, false))
    }
}

#[pymethods]
impl Run {
    /// The folder; `None` if the run is in memory.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.folder().map(Path::to_path_buf)
    }

    /// The case.
    #[getter]
    fn case(&self, py: Python<'_>) -> PyResult<Case> {
        let inner = match &*self.place {
            Place::Memory { case, .. } => (**case).clone(),
            Place::Folder { .. } => self.read(py, granum_io::Run::case)?,
        };
        Ok(Case { inner })
    }

    /// What it is.
    #[getter]
    fn kind(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(if self.about(py)?.kind == RunKind::Sample { "sample" } else { "test" })
    }

    /// Its status.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        serialised(py, &self.about(py)?.status)
    }

    /// What the run says about itself, as its file `run.json`.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        serialised(py, &self.about(py)?)
    }

    /// Quantities that the run measured once, in SI units.
    #[getter]
    fn measures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, value) in self.about(py)?.measures {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// The quality checks: `name`, `value`, `limit`, `passed`, and what to do if it did not pass (`advice`).
    #[getter]
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        serialised(py, &self.about(py)?.quality)
    }

    /// True if the run is finished and passed all quality checks.
    #[getter]
    fn is_good(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.about(py)?.is_good())
    }

    /// Remarks of the run.
    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.about(py)?.notes)
    }

    /// The names of its tables.
    #[getter]
    pub fn tables(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        match &*self.place {
            Place::Folder { .. } => self.read(py, |run| run.now().tables()),
            Place::Memory { result, .. } => {
                let histograms = result.record.histogram_tables().map(|(name, _)| name.to_string());
                Ok(std::iter::once(SERIES.to_string()).chain(histograms).collect())
            }
        }
    }

    /// The table of that name.
    pub fn table<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let found = match &*self.place {
            Place::Folder { .. } => {
                // Of a run that goes on there may be more in a moment.
                let known = self.tables(py)?;
                if !known.iter().any(|known| known == name) {
                    return Err(no_table(NO_TABLE, name, &known));
                }
                self.read(py, |run| run.now().table_named(name))?
            }
            Place::Memory { result, .. } if name == SERIES => result.record.series.clone(),
            Place::Memory { result, .. } => {
                let found = result.record.histogram_tables().find(|(known, _)| *known == name);
                let Some((_, found)) = found else { return Err(no_table(NO_TABLE, name, &self.tables(py)?)) };
                found
            }
        };
        table::object(py, found)
    }

    /// The recorded states of a test, a row a state.
    #[getter]
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py, SERIES)
    }

    /// The names of its snapshots.
    #[getter]
    fn snapshots(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        match &*self.place {
            Place::Folder { .. } => self.read(py, |run| run.now().snapshots()),
            Place::Memory { result, .. } => Ok(result.state.iter().map(|_| END.to_string()).collect()),
        }
    }

    /// All grains and contacts at a snapshot; by default that at the end.
    #[pyo3(signature = (name=None))]
    pub fn snapshot(&self, py: Python<'_>, name: Option<String>) -> PyResult<Assembly> {
        let known = self.snapshots(py)?;
        let usual = || known.iter().find(|name| *name == END).or(known.first()).cloned();
        let name = name.or_else(usual).unwrap_or_else(|| END.into());
        if !known.contains(&name) {
            return Err(errors::of_key("the run has no snapshot", &name, known.iter().map(String::as_str)));
        }
        match &*self.place {
            Place::Folder { .. } => Ok(self.read(py, |run| run.now().snapshot(&name))?.into()),
            Place::Memory { result, .. } => {
                let assembly = detached(py, || Ok(result.simulation()?.assembly()))?;
                let assembly = assembly.map_err(|error| errors::of_laboratory(py, &error))?;
                Ok(assembly.into())
            }
        }
    }

    /// The simulation as it was at the end of the run, or at its last checkpoint, to go on by hand.
    fn simulation(&self, py: Python<'_>) -> PyResult<Simulation> {
        let place = self.place.clone();
        let found = detached(py, move || match &*place {
            Place::Folder { run, .. } => Laboratory::here().last_state(run.path()),
            Place::Memory { result, .. } => result.simulation().cloned(),
        })?;
        found.map(Simulation::new).map_err(|error| errors::of_laboratory(py, &error))
    }

    /// SHA-256 of all results of a run in a folder: the same as `granum digest` gives.
    fn digest(&self, py: Python<'_>) -> PyResult<String> {
        self.read(py, |run| digest::of_run(&run.now()))
    }

    /// The report of the run as the text of a self-contained page. With `out`, a file `.html` or a folder, it is also written.
    #[pyo3(signature = (out=None, *, force=false))]
    fn report(&self, py: Python<'_>, out: Option<PathBuf>, force: bool) -> PyResult<String> {
        let document = report::document(py, &self.place, true)?;
        if let Some(out) = out {
            report::write(py, &document, &out, force)?;
        }
        Ok(document.html)
    }

    /// Draws columns of the states over another one, by default a strain, with matplotlib; returns the axes.
    #[pyo3(signature = (y, x=None, axes=None, **style))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        y: &Bound<'py, PyAny>,
        x: Option<&str>,
        axes: Option<&Bound<'py, PyAny>>,
        style: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("granum._plots")?.call_method("plot", (slf, y, x, axes), style)
    }

    /// The report without the pictures of the grains, which would make a notebook large.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let page = report::document(py, &self.place, false)?.html;
        py.import("granum._plots")?.call_method1("frame", (page,))?.extract()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PathBuf,))> {
        match &*self.place {
            Place::Folder { run, kept: None } => {
                Ok((py.import("granum")?.getattr("open")?, (std::path::absolute(run.path())?,)))
            }
            _ => Err(PyTypeError::new_err(
                "a run that is kept in memory cannot be pickled; give out=\"NAME\" when you run it",
            )),
        }
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let about = self.about(py)?;
        let place = match &*self.place {
            Place::Folder { run, .. } => run.path().display().to_string(),
            Place::Memory { .. } => "in memory".into(),
        };
        let status = values::from_json(py, &serde_json::json!(about.status))?;
        Ok(format!("<granum.Run {place}: {} of {} grains, {status}>", self.kind(py)?, about.grains))
    }
}

const NO_TABLE: &str = "the run has no table";
/// The snapshot at the end of a run.
const END: &str = "end";
