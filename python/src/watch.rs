//! Python's functions as the observer of a run: progress, states, and Ctrl-C.

use std::time::{Duration, Instant};

use granum_core::observer::{Event, Flow, NamedValue, Observer, Progress};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::values;

/// How often progress is told, and how often Python is asked for Ctrl-C.
const EVERY: Duration = Duration::from_millis(100);

/// An observer that calls Python. What a function raises stops the run in good order and is raised again after it.
pub struct Watch {
    on_state: Option<Py<PyAny>>,
    on_progress: Option<Py<PyAny>>,
    told: Option<Instant>,
    asked: Instant,
    pub raised: Option<PyErr>,
    pub warnings: Vec<String>,
    stopped: bool,
}

impl Watch {
    pub fn new(on_state: Option<Py<PyAny>>, on_progress: Option<Py<PyAny>>) -> Watch {
        let (told, raised, warnings) = (None, None, Vec::new());
        Watch { on_state, on_progress, told, asked: Instant::now(), raised, warnings, stopped: false }
    }

    /// Calls Python; the run stops if the function returns `False` or raises, and if the interpreter ends.
    fn call_with(
        &mut self,
        function: &Py<PyAny>,
        argument: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyAny>>,
    ) {
        let answer = Python::try_attach(|py| {
            let answer = function.bind(py).call1((argument(py)?,))?;
            Ok(answer.extract::<bool>().is_ok_and(|go_on| !go_on))
        });
        match answer {
            Some(Ok(stop)) => self.stopped |= stop,
            Some(Err(error)) => {
                self.stopped = true;
                self.raised = self.raised.take().or(Some(error));
            }
            None => self.stopped = true,
        }
    }

    fn flow(&mut self, report: &Progress) -> Flow {
        if !self.stopped && self.asked.elapsed() >= EVERY {
            self.asked = Instant::now();
            match Python::try_attach(|py| py.check_signals()) {
                Some(Ok(())) => {}
                Some(Err(error)) => (self.stopped, self.raised) = (true, Some(error)),
                // The interpreter ends, and this thread outlives it.
                None => self.stopped = true,
            }
        }
        let due = self.told.is_none_or(|told| told.elapsed() >= EVERY);
        if let Some(function) = self.on_progress.take() {
            if due && !self.stopped {
                self.told = Some(Instant::now());
                self.call_with(&function, |py| object(py, report));
            }
            self.on_progress = Some(function);
        }
        if self.stopped { Flow::Stop } else { Flow::Continue }
    }
}

/// Progress as a dict.
fn object<'py>(py: Python<'py>, report: &Progress) -> PyResult<Bound<'py, PyAny>> {
    let dict = PyDict::new(py);
    dict.set_item("activity", report.activity.as_ref())?;
    dict.set_item("part", &report.part)?;
    dict.set_item("counted", report.counted.as_ref())?;
    dict.set_item("done", report.done)?;
    dict.set_item("of", report.of)?;
    dict.set_item("fraction", report.completed())?;
    dict.set_item("values", named(py, &report.values)?)?;
    Ok(dict.into_any())
}

fn named<'py>(py: Python<'py>, list: &[NamedValue]) -> PyResult<Bound<'py, PyAny>> {
    let dict = PyDict::new(py);
    for value in list {
        dict.set_item(value.name.as_ref(), value.value)?;
    }
    Ok(dict.into_any())
}

impl Observer for Watch {
    fn progress(&mut self, progress: &Progress) -> Flow {
        self.flow(progress)
    }

    fn event(&mut self, event: &Event) {
        match event {
            Event::Warning { text } => self.warnings.push(text.clone()),
            Event::StateRecorded { values } if !self.stopped => {
                if let Some(function) = self.on_state.take() {
                    self.call_with(&function, |py| named(py, values));
                    self.on_state = Some(function);
                }
            }
            _ => {}
        }
    }
}

/// What some work gave, after its warnings were shown. What a function of the user raised is the reason why the work stopped, and is raised
/// whatever the work says about its end.
pub fn told<T, E>(
    py: Python<'_>,
    watch: Watch,
    done: Result<T, E>,
    as_exception: impl FnOnce(&E) -> PyErr,
) -> PyResult<T> {
    let warned = warn(py, &watch.warnings);
    match (watch.raised, done) {
        (Some(error), _) => Err(error),
        (None, Err(error)) => Err(as_exception(&error)),
        (None, Ok(done)) => warned.map(|()| done),
    }
}

/// Shows warnings of granum as warnings of Python.
pub fn warn(py: Python<'_>, warnings: &[String]) -> PyResult<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    let class = py.import("granum.errors")?.getattr("RunWarning")?;
    let warn = py.import("warnings")?.getattr("warn")?;
    warnings.iter().try_for_each(|text| warn.call1((text, &class)).map(drop))
}

/// A value that can be serialised as a value of Python.
pub fn serialised<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    let json =
        serde_json::to_value(value).map_err(|error| crate::errors::internal(py, &error.to_string()))?;
    values::from_json(py, &json)
}
