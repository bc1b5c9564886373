//! The recorder of a simulation that is advanced by hand.

use std::sync::{Mutex, MutexGuard, PoisonError};

use granum_dem::config::RecordedColumns;
use granum_dem::loading::RecordedStates;
use granum_sensors::{Record, Recorder as Inner};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::assembly::Assembly;
use crate::case::case_of;
use crate::detached::detached;
use crate::errors;
use crate::sensor::Sensors;
use crate::simulation::Simulation;
use crate::table::{self, SERIES, no_table};

/// Records states of a simulation that is advanced by hand, with every sensor that tests record.
///
/// `case` gives the keys of `[recording]`: further sensors by name, their parameters and bins. `sensors` adds names of sensors and sensors of
/// one's own.
#[pyclass(frozen, module = "granum")]
pub struct Recorder {
    /// Nothing while a state is recorded: sensors of the user may then run, and nobody may wait for them with Python's lock.
    inner: Mutex<Option<Box<Inner>>>,
}

impl Recorder {
    fn slot(&self) -> MutexGuard<'_, Option<Box<Inner>>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn see<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&Inner) -> T + Send) -> PyResult<T> {
        detached(py, || self.slot().as_deref().map(look))?.ok_or_else(|| absent(py))
    }

    /// The record of the states so far.
    fn record_of(&self, py: Python<'_>) -> PyResult<Record> {
        self.see(py, |recorder| Inner::record_of_stages([recorder], RecordedColumns::All))
    }
}

fn absent(py: Python<'_>) -> PyErr {
    errors::of_running(py, "the recorder is recording a state")
}

#[pymethods]
impl Recorder {
    #[new]
    #[pyo3(signature = (case=None, *, sensors=None))]
    fn new(
        py: Python<'_>,
        case: Option<&Bound<'_, PyAny>>,
        sensors: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Recorder> {
        let mut recording = match case {
            Some(case) => case_of(py, case)?.recording,
            None => granum_io::Case::default().recording,
        };
        let sensors = Sensors::from_list(py, sensors)?;
        sensors.record(&mut recording);
        let known = sensors.registry.runs.vocabulary.sensors();
        let states = RecordedStates::default();
        let inner = Inner::of_stage(known, &recording, RecordedColumns::All, &states, 0.0);
        let inner = inner.map_err(|error| errors::of_value(py, "sensors", "", error.to_string()))?;
        Ok(Recorder { inner: Mutex::new(Some(Box::new(inner))) })
    }

    /// Records what a simulation, or an assembly, is like now as the next state, of one observation. A sensor that raises leaves the
    /// recorder as it was.
    fn record(&self, py: Python<'_>, of: &Bound<'_, PyAny>) -> PyResult<()> {
        let assembly = if let Ok(simulation) = of.cast::<Simulation>() {
            simulation.get().observed(py)?
        } else if let Ok(assembly) = of.cast::<Assembly>() {
            assembly.get().whole(py)?
        } else {
            let kind = of.get_type().name()?;
            return Err(PyTypeError::new_err(format!(
                "a granum.Simulation or a granum.Assembly is recorded, not {kind}"
            )));
        };
        let mut recorder = self.slot().take().ok_or_else(|| absent(py))?;
        // A sensor that raises leaves the recorder as it was.
        let done = detached(py, || recorder.observe_state(&assembly));
        *self.slot() = Some(recorder);
        done
    }

    /// The recorded states, a row a state.
    #[getter]
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        table::object(py, self.record_of(py)?.series)
    }

    /// The names of its tables: the series and the histograms of the sensors.
    #[getter]
    fn tables(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let record = self.record_of(py)?;
        let histograms = record.histograms.iter().map(|histogram| histogram.name.clone());
        Ok(std::iter::once(SERIES.to_string()).chain(histograms).collect())
    }

    /// The table of that name.
    fn table<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if name == SERIES {
            return self.series(py);
        }
        let record = self.record_of(py)?;
        let found = record.histogram_tables().find(|(known, _)| *known == name);
        match found {
            Some((_, found)) => table::object(py, found),
            None => Err(no_table("the recorder has no table", name, &self.tables(py)?)),
        }
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.see(py, Inner::states)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<granum.Recorder of {} states>", self.__len__(py)?))
    }
}
