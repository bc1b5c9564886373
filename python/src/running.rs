//! Preparing samples, running tests, and resuming them.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use granum::Registry;
use granum_core::quantity::Dimension;
use granum_io::{RunFolder, RunKind, RunStatus};
use granum_run::{Laboratory, LaboratoryError, PlannedRun, Source};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use tempfile::TempDir;

use crate::case::{Case, case_of};
use crate::detached::detached;
use crate::errors;
use crate::quantity;
use crate::run::Run;
use crate::sensor::Sensors;
use crate::watch::{self, Watch};

/// Most threads of a run.
const MOST_THREADS: u64 = 4096;

/// What a run may use of the computer; results do not depend on it.
struct Means<'a, 'py> {
    threads: Option<&'a Bound<'py, PyAny>>,
    checkpoint_every: Option<&'a Bound<'py, PyAny>>,
}

impl Means<'_, '_> {
    /// A laboratory that knows what is in a registry.
    fn laboratory(&self, py: Python<'_>, registry: Registry) -> PyResult<Laboratory> {
        let mut laboratory = Laboratory::here().with_registry(registry);
        if let Some(threads) = self.threads {
            laboratory.resources.hardware.threads =
                quantity::whole("threads", threads, 1, MOST_THREADS)? as usize;
            laboratory.resources.grains_per_thread = 1;
        }
        if let Some(seconds) = self.checkpoint_every {
            let seconds = quantity::in_si("checkpoint_every", seconds, Dimension::TIME)?;
            let every = Duration::try_from_secs_f64(seconds);
            laboratory.resources.checkpoint_every = every.map_err(|_| {
                let message = "the time between two checkpoints is a positive number of seconds";
                errors::of_value(py, "checkpoint_every", seconds.to_string(), message)
            })?;
        }
        Ok(laboratory)
    }
}

/// What a run gave.
fn told<T>(py: Python<'_>, watch: Watch, done: Result<T, LaboratoryError>) -> PyResult<T> {
    watch::told(py, watch, done, |error| errors::of_laboratory(py, error))
}

/// Plans a run: whatever is wrong with its inputs is known before a folder is made.
fn planned(
    py: Python<'_>,
    laboratory: &Laboratory,
    kind: RunKind,
    case: &granum_io::Case,
    source: &Source,
    mut watch: Watch,
) -> PyResult<(PlannedRun, Watch)> {
    match detached(py, || laboratory.plan(kind, case, source, &mut watch))? {
        Ok(plan) if watch.raised.is_none() => Ok((plan, watch)),
        plan => told(py, watch, plan).and_then(|_| Err(errors::internal(py, "a stop without a reason"))),
    }
}

/// Executes a run in a folder.
fn in_folder(
    py: Python<'_>,
    planned: PlannedRun,
    out: &Path,
    force: bool,
    mut watch: Watch,
    kept: Option<Arc<TempDir>>,
) -> PyResult<Run> {
    let folder = RunFolder::create(out, force).map_err(|error| errors::of_file(py, &error, false))?;
    let done = detached(py, || planned.in_folder(&folder, &mut watch));
    let done = done.inspect_err(|_| interrupted(&folder))?;
    let run = folder.run();
    drop(folder);
    told(py, watch, done).map(|_| Run::in_folder(run, kept))
}

/// Notes in the record that nobody works on a run any more that a sensor of the user has ended: it is resumed from its last checkpoint.
fn interrupted(folder: &RunFolder) {
    if let Ok(mut record) = folder.run().record() {
        record.status = RunStatus::Interrupted;
        // What the user is told is why the run ended.
        let _ = folder.write_record(&record);
    }
}

/// Prepares the sample of a case, in the folder `out` or, without one, in a temporary folder that lives as long as the run.
///
/// `packing` is a file of grains that take the place of the random insertion. Results do not depend on `threads`. `checkpoint_every` are
/// seconds. `on_progress` is called about ten times a second with a dict; if it returns `False`, the preparation stops in good order. With
/// `force` a run that is in the folder is replaced. Ctrl-C stops in good order too, and `granum.resume` goes on, if there is a folder `out`.
#[pyfunction]
#[pyo3(signature = (case, *, packing=None, out=None, threads=None, checkpoint_every=None, on_progress=None, force=false))]
pub fn prepare(
    py: Python<'_>,
    case: &Bound<'_, PyAny>,
    packing: Option<PathBuf>,
    out: Option<PathBuf>,
    threads: Option<&Bound<'_, PyAny>>,
    checkpoint_every: Option<&Bound<'_, PyAny>>,
    on_progress: Option<Py<PyAny>>,
    force: bool,
) -> PyResult<Run> {
    let case = case_of(py, case)?;
    let laboratory = Means { threads, checkpoint_every }.laboratory(py, Registry::standard())?;
    let source = packing.map_or(Source::Case, Source::Packing);
    let watch = Watch::new(None, on_progress);
    let (plan, watch) = planned(py, &laboratory, RunKind::Sample, &case, &source, watch)?;
    match out {
        Some(out) => in_folder(py, plan, &out, force, watch, None),
        None => {
            let kept = Arc::new(tempfile::Builder::new().prefix("granum-").tempdir()?);
            let out = kept.path().join("sample");
            in_folder(py, plan, &out, false, watch, Some(kept))
        }
    }
}

/// The source of a sample: a run of a sample, its folder, or the case.
fn source_of(sample: Option<&Bound<'_, PyAny>>, packing: Option<PathBuf>) -> PyResult<Source> {
    let sample = match (sample, packing) {
        (Some(_), Some(_)) => return Err(PyTypeError::new_err("give a sample or a packing, not both")),
        (None, Some(packing)) => return Ok(Source::Packing(packing)),
        (None, None) => return Ok(Source::Case),
        (Some(sample), None) => sample,
    };
    if let Ok(run) = sample.cast::<Run>() {
        let folder = run.get().folder().map(|path| Source::Folder(path.to_path_buf()));
        return folder.ok_or_else(|| {
            PyTypeError::new_err("a sample is what granum.prepare returns, not a test in memory")
        });
    }
    sample.extract::<PathBuf>().map(Source::Folder).map_err(|_| {
        PyTypeError::new_err("a sample is what granum.prepare returns, or the folder that it wrote")
    })
}

/// Carries out the test of a case, or a named `path` with its `parameters`, or a list of stages, in the folder `out` or in memory.
///
/// `sample` is what `prepare` returned or the folder that it wrote; without it the sample is prepared first. `on_state` is called with the
/// values of the columns of each state that is recorded; if it returns `False`, the test stops in good order. `sensors` are recorded with
/// the rest, as those that `recording.sensors` names: names, and sensors of one's own (`granum.Sensor`). The other arguments are those of
/// `prepare`. What `on_state` and `on_progress` raise is raised after the run was stopped in good order; what a sensor raises ends the run
/// at its last checkpoint, from which `granum.resume` goes on.
#[pyfunction]
#[pyo3(name = "run", signature = (case, sample=None, *, path=None, packing=None, out=None, threads=None, checkpoint_every=None, sensors=None, on_state=None, on_progress=None, force=false, **parameters))]
pub fn run_case(
    py: Python<'_>,
    case: &Bound<'_, PyAny>,
    sample: Option<&Bound<'_, PyAny>>,
    path: Option<&Bound<'_, PyAny>>,
    packing: Option<PathBuf>,
    out: Option<PathBuf>,
    threads: Option<&Bound<'_, PyAny>>,
    checkpoint_every: Option<&Bound<'_, PyAny>>,
    sensors: Option<&Bound<'_, PyAny>>,
    on_state: Option<Py<PyAny>>,
    on_progress: Option<Py<PyAny>>,
    force: bool,
    parameters: Option<&Bound<'_, PyDict>>,
) -> PyResult<Run> {
    let mut case = case_of(py, case)?;
    match (path, parameters) {
        (Some(path), parameters) if path.is_instance_of::<PyString>() => {
            case = Case { inner: case }.along(py, &path.extract::<String>()?, parameters)?.inner;
        }
        (Some(path), _) if path.is_callable() => {
            let message = "a function is followed by hand, with granum.Simulation.follow: what it does is no part of a case";
            return Err(PyTypeError::new_err(message));
        }
        (Some(_), Some(parameters)) if !parameters.is_empty() => {
            let names: Vec<String> = parameters.keys().iter().map(|name| name.to_string()).collect();
            let message = format!("{} with a list of stages: give it in a stage", names.join(", "));
            return Err(PyTypeError::new_err(message));
        }
        (Some(stages), _) => case = Case { inner: case }.in_stages(py, stages)?.inner,
        (None, Some(parameters)) if !parameters.is_empty() => {
            let names: Vec<String> = parameters.keys().iter().map(|name| name.to_string()).collect();
            let message = format!("{} without a path: give path=\"NAME\" too", names.join(", "));
            return Err(PyTypeError::new_err(message));
        }
        _ => {}
    }
    let sensors = Sensors::from_list(py, sensors)?;
    sensors.record(&mut case.recording);
    let laboratory = Means { threads, checkpoint_every }.laboratory(py, sensors.registry)?;
    let source = source_of(sample, packing)?;
    let watch = Watch::new(on_state, on_progress);
    let (plan, mut watch) = planned(py, &laboratory, RunKind::Test, &case, &source, watch)?;
    if let Some(out) = out {
        return in_folder(py, plan, &out, force, watch, None);
    }
    let done = detached(py, || plan.in_memory(&mut watch))?;
    told(py, watch, done).map(|result| Run::in_memory(case, result))
}

/// Continues a run that was interrupted or killed, to the bits of one that was not. A finished run is returned as it is.
///
/// A run needs nothing outside its folder once it has begun: the sample from which it began may be gone. Sensors of one's own that the run
/// records have to be given again as `sensors`.
#[pyfunction]
#[pyo3(signature = (folder, *, threads=None, checkpoint_every=None, sensors=None, on_state=None, on_progress=None))]
pub fn resume(
    py: Python<'_>,
    folder: &Bound<'_, PyAny>,
    threads: Option<&Bound<'_, PyAny>>,
    checkpoint_every: Option<&Bound<'_, PyAny>>,
    sensors: Option<&Bound<'_, PyAny>>,
    on_state: Option<Py<PyAny>>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Run> {
    let (path, kept) = match folder.cast::<Run>() {
        Ok(run) => (run.get().folder().map(Path::to_path_buf), run.get().kept()),
        Err(_) => (Some(folder.extract::<PathBuf>()?), None),
    };
    let Some(path) = path else {
        return Err(PyTypeError::new_err(
            "a run in memory cannot be resumed; give out=\"NAME\" when you run it",
        ));
    };
    let registry = Sensors::from_list(py, sensors)?.registry;
    let laboratory = Means { threads, checkpoint_every }.laboratory(py, registry)?;
    let mut watch = Watch::new(on_state, on_progress);
    // A folder that holds no run is refused before it is locked.
    let run = granum_io::Run::at(&path).map_err(|error| errors::of_file(py, &error, false))?;
    let folder = RunFolder::open(&path).map_err(|error| errors::of_file(py, &error, false))?;
    let done = detached(py, || laboratory.resume(&folder, &mut watch));
    let done = done.inspect_err(|_| interrupted(&folder))?;
    drop(folder);
    told(py, watch, done).map(|_| Run::in_folder(run.now(), kept))
}

/// The run in a folder, also while another process writes it.
#[pyfunction]
#[pyo3(name = "open")]
pub fn open_run(py: Python<'_>, folder: PathBuf) -> PyResult<Run> {
    let run = Registry::standard().run_at(&folder).map_err(|error| errors::of_file(py, &error, false))?;
    Ok(Run::in_folder(run, None))
}
