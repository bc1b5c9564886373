//! Campaigns: the runs of a plan, which is written as the text of a plan file and read by the rules of one.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use granum::Registry;
use granum::contents::{FolderKind, check_free};
use granum_campaign::data_set;
use granum_campaign::execution::{CampaignObserver, CampaignProgress, ChildProcesses, Coordinator, Summary};
use granum_campaign::plan::{Plan, PlanSource, PlannedRuns};
use granum_campaign::{CampaignStatus, PlanDifference, RUNS, RunState};
use granum_core::quantity::Dimension;
use granum_core::{Column, Table};
use granum_io::OutputFolder;
use granum_run::queue::QueueError;
use granum_run::{Flow, Laboratory};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PyType};

use crate::case::Case;
use crate::case_text;
use crate::detached::detached;
use crate::errors;
use crate::quantity;
use crate::run::Run;
use crate::table;
use crate::watch;

/// The name of a plan that was made in Python, for messages.
const MADE: &str = "plan";
/// The file of its base case.
const CASE: &str = "case.toml";
/// Most runs at once.
const MOST_WORKERS: u64 = 4096;
/// How often Python is told and asked.
const EVERY: Duration = Duration::from_millis(100);

/// A campaign: planned, or read from its folder.
#[pyclass(frozen, name = "_CampaignFolder", module = "granum._granum")]
pub struct CampaignFolder {
    campaign: granum_campaign::Campaign,
}

/// The text of a plan with its base case.
fn planned(py: Python<'_>, text: &str, case: &granum_io::Case) -> PyResult<(Plan, PlannedRuns)> {
    let folder = tempfile::Builder::new().prefix("granum-").tempdir()?;
    let base = case.readable_toml(None).map_err(|error| errors::of_file(py, &error, true))?;
    std::fs::write(folder.path().join(CASE), base)?;
    let source = PlanSource { file: MADE.into(), folder: folder.path().to_path_buf(), text: Arc::from(text) };
    let found = detached(py, || {
        let plan = Plan::parse(source, Registry::standard().reading())?;
        let runs = plan.runs()?;
        Ok((plan, runs))
    })?;
    found.map_err(|error| errors::of_file(py, &error, true))
}

#[pymethods]
impl CampaignFolder {
    /// The campaign of a plan, given as the sections of a plan file, in a folder that is not made yet.
    #[new]
    fn new(
        py: Python<'_>,
        case: &Case,
        plan: &Bound<'_, PyMapping>,
        folder: PathBuf,
    ) -> PyResult<CampaignFolder> {
        let text = format!("case = \"{CASE}\"\n{}", case_text::text_of(plan)?);
        let (plan, runs) = planned(py, &text, &case.inner)?;
        let campaign = granum_campaign::Campaign::new(&folder, &plan, &runs, env!("CARGO_PKG_VERSION"));
        Ok(CampaignFolder { campaign })
    }

    #[classmethod]
    fn open(_class: &Bound<'_, PyType>, py: Python<'_>, folder: PathBuf) -> PyResult<CampaignFolder> {
        let read = detached(py, || {
            let registry = Registry::standard();
            let found = granum_campaign::Campaign::read(&folder, &registry.runs.vocabulary)?;
            found.ok_or_else(|| granum_io::Error::content(&folder, "is not the folder of a campaign"))
        })?;
        let campaign = read.map_err(|error| errors::of_file(py, &error, false))?;
        Ok(CampaignFolder { campaign })
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.campaign.folder().to_path_buf()
    }

    #[getter]
    fn case(&self) -> Case {
        Case { inner: self.campaign.base().clone() }
    }

    #[getter]
    fn plan(&self) -> &str {
        self.campaign.plan_text()
    }

    #[getter]
    fn names(&self) -> Vec<&str> {
        self.campaign.runs().iter().map(|run| run.name.as_str()).collect()
    }

    /// The case of a run.
    fn case_of(&self, py: Python<'_>, name: &str) -> PyResult<Case> {
        let run = self.campaign.queued(name).map_err(|error| errors::of_file(py, &error, false))?;
        Ok(Case { inner: run.case })
    }

    /// The run of a name, once it has begun.
    fn run(&self, py: Python<'_>, name: &str) -> PyResult<Run> {
        let known = self.campaign.runs().iter().map(|run| run.name.as_str());
        if !known.clone().any(|known| known == name) {
            return Err(errors::of_key("the campaign has no run", name, known));
        }
        let found = Registry::standard().run_at(self.campaign.folder_of(name));
        found.map(|run| Run::in_folder(run, None)).map_err(|error| errors::of_file(py, &error, false))
    }

    /// The runs with the values of the variables and the state of each.
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let status = self.status_of_runs(py)?;
        let runs = self.campaign.runs();
        let mut columns = vec![Column::of_words("run", runs.iter().map(|run| run.name.as_str()))];
        for (place, variable) in self.campaign.variables().iter().enumerate() {
            let values = runs.iter().map(|run| run.values.get(place));
            let numbers: Option<Vec<f64>> =
                values.clone().map(|value| value.and_then(|value| value.number())).collect();
            columns.push(match numbers {
                Some(numbers) => Column::new(&variable.name, &variable.unit, numbers),
                None => {
                    let text = |value: Option<&granum_campaign::plan::RunValue>| {
                        value.map(ToString::to_string).unwrap_or_default()
                    };
                    Column::of_words(&variable.name, values.map(text))
                }
            });
        }
        columns.push(Column::of_words("status", status.states.iter().map(RunState::word)));
        let found = Table::new(columns).map_err(|error| errors::general(py, error.to_string()))?;
        table::object(py, found)
    }

    /// Why runs failed, and which checks were not passed, by the name of the run.
    #[getter]
    fn remarks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        let status = self.status_of_runs(py)?;
        for (run, state) in self.campaign.runs().iter().zip(&status.states) {
            let remark = match state {
                RunState::Failed { reason } => reason.clone(),
                RunState::Finished { flags, .. } if !flags.is_empty() => {
                    flags.iter().map(|flag| flag.name.clone()).collect::<Vec<_>>().join(", ")
                }
                _ => continue,
            };
            found.set_item(&run.name, remark)?;
        }
        Ok(found)
    }

    #[getter]
    fn is_done(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.status_of_runs(py)?.is_done())
    }

    /// Carries out all runs that are not finished, each in a process of its own that `program` starts, and writes the data set.
    #[pyo3(signature = (program, *, workers=None, stop_after=None, again=false, force=false, on_progress=None))]
    fn carry_out(
        &self,
        py: Python<'_>,
        program: PathBuf,
        workers: Option<&Bound<'_, PyAny>>,
        stop_after: Option<&Bound<'_, PyAny>>,
        again: bool,
        force: bool,
        on_progress: Option<Py<PyAny>>,
    ) -> PyResult<bool> {
        let workers = workers.map(|count| quantity::whole("workers", count, 1, MOST_WORKERS)).transpose()?;
        let workers = workers.map(|count| count as usize);
        let stop_after =
            stop_after.map(|time| quantity::in_si("stop_after", time, Dimension::TIME)).transpose()?;
        let stop_after = stop_after.map(Duration::try_from_secs_f64).transpose().map_err(|_| {
            errors::of_value(
                py,
                "stop_after",
                "",
                "the time after which runs end is a positive number of seconds",
            )
        })?;
        let watch = CampaignWatch::new(on_progress);
        let done = detached(py, || self.carried_out(program, (workers, stop_after), again, force, &watch))?;
        let (raised, warnings) = watch.into_parts();
        let warned = watch::warn(py, &warnings);
        match (raised, done) {
            (Some(error), _) => Err(error),
            (None, Err(error)) => Err(of_campaign(py, &error)),
            (None, Ok(summary)) => warned.map(|()| !summary.stopped),
        }
    }

    fn __repr__(&self) -> String {
        let (folder, count) = (self.campaign.folder().display(), self.campaign.runs().len());
        format!("<granum.Campaign {folder}: {count} runs>")
    }
}

impl CampaignFolder {
    fn status_of_runs(&self, py: Python<'_>) -> PyResult<CampaignStatus> {
        let status = detached(py, || CampaignStatus::read(&self.campaign))?;
        status.map_err(|error| errors::of_file(py, &error, false))
    }

    fn carried_out(
        &self,
        program: PathBuf,
        (workers, stop_after): (Option<usize>, Option<Duration>),
        again: bool,
        force: bool,
        watch: &CampaignWatch,
    ) -> Result<Summary, CampaignError> {
        let folder = self.campaign.folder();
        let registry = Registry::standard();
        let vocabulary = &registry.runs.vocabulary;
        check_free(folder, FolderKind::Campaign, true, vocabulary)?;
        let mut campaign = self.campaign.clone();
        if let Some(earlier) = granum_campaign::Campaign::read(folder, vocabulary)? {
            campaign = campaign.after(&earlier);
            let PlanDifference { kept, added, dropped } = campaign.difference(&earlier);
            if added > 0 || !dropped.is_empty() {
                let left = dropped.len();
                watch.warn(&format!(
                    "the plan was changed: {kept} runs are still in it, {added} are new, {left} are no longer in it, and \
                     their folders stay"
                ));
            }
        }
        let laboratory = campaign.laboratory(&Laboratory::here().with_registry(registry));
        laboratory.registry.engines.named(&laboratory.engine).map_err(granum_run::LaboratoryError::from)?;
        let executor = ChildProcesses::new(program, folder, Vec::new());
        let again = again || force;
        let (campaign, laboratory) = (&campaign, &laboratory);
        let coordinator =
            Coordinator { campaign, laboratory, executor: &executor, workers, stop_after, again };
        coordinator.check(force)?;
        let held = OutputFolder::open_or_create(folder)?;
        held.refuse_links(&[RUNS])?;
        campaign.write()?;
        let summary = coordinator.run(&held, force, watch)?;
        if !summary.stopped {
            let collected = data_set::collect(campaign, &|| watch.flow())?;
            collected.remarks.iter().for_each(|remark| watch.warn(remark));
            if collected.data_set.is_none() {
                watch.warn("there is no data set, since none of the runs is part of it: see `remarks` of the campaign");
            }
        }
        Ok(summary)
    }
}

/// Why a campaign could not be carried out.
enum CampaignError {
    Learn(granum_learn::LearnError),
    Queue(QueueError),
    File(granum_io::Error),
    Laboratory(granum_run::LaboratoryError),
}

macro_rules! from {
    ($($source:ty => $variant:ident),*) => {$(
        impl From<$source> for CampaignError {
            fn from(error: $source) -> CampaignError {
                CampaignError::$variant(error)
            }
        }
    )*};
}

from!(granum_learn::LearnError => Learn, QueueError => Queue, granum_io::Error => File, granum_run::LaboratoryError => Laboratory);

fn of_campaign(py: Python<'_>, error: &CampaignError) -> PyErr {
    match error {
        CampaignError::Learn(error) => errors::of_learning(py, error),
        CampaignError::File(error) | CampaignError::Queue(QueueError::File(error)) => {
            errors::of_file(py, error, false)
        }
        CampaignError::Laboratory(error) => errors::of_laboratory(py, error),
        CampaignError::Queue(error @ QueueError::OtherRun { .. }) => {
            errors::of_running(py, &format!("{error}; give force=True to replace it, or another folder"))
        }
        CampaignError::Queue(error) => errors::of_running(py, &error.to_string()),
    }
}

/// Python's function as the observer of a campaign. It is called by the threads of the coordinator, never while something of this is
/// locked.
struct CampaignWatch {
    on_progress: Option<Py<PyAny>>,
    stopped: AtomicBool,
    kept: Mutex<Kept>,
}

/// What the threads leave.
struct Kept {
    raised: Option<PyErr>,
    warnings: Vec<String>,
    told: Option<Instant>,
    asked: Instant,
}

impl CampaignWatch {
    fn new(on_progress: Option<Py<PyAny>>) -> CampaignWatch {
        let kept = Kept { raised: None, warnings: Vec::new(), told: None, asked: Instant::now() };
        CampaignWatch { on_progress, stopped: AtomicBool::new(false), kept: Mutex::new(kept) }
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn into_parts(self) -> (Option<PyErr>, Vec<String>) {
        let kept = self.kept.into_inner().unwrap_or_else(PoisonError::into_inner);
        (kept.raised, kept.warnings)
    }

    /// Keeps what a call of Python raised; the interpreter may be gone.
    fn after(&self, answer: Option<PyResult<bool>>) {
        match answer {
            Some(Ok(true)) => {}
            Some(Ok(false)) | None => self.stopped.store(true, Ordering::Relaxed),
            Some(Err(error)) => {
                self.stopped.store(true, Ordering::Relaxed);
                let mut kept = self.kept();
                if kept.raised.is_none() {
                    kept.raised = Some(error);
                }
            }
        }
    }
}

/// Progress as a dict like that of a run.
fn object<'py>(py: Python<'py>, progress: &CampaignProgress) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("activity", "campaign")?;
    dict.set_item("part", py.None())?;
    dict.set_item("counted", "runs")?;
    dict.set_item("done", progress.finished)?;
    dict.set_item("of", progress.runs)?;
    dict.set_item("fraction", progress.share)?;
    let values = PyDict::new(py);
    values.set_item("failed", progress.failed)?;
    values.set_item("flagged", progress.flagged)?;
    values.set_item("running", progress.running)?;
    values.set_item("runs_per_hour", progress.runs_per_hour)?;
    values.set_item("seconds_left", progress.left.map(|left| left.as_secs_f64()))?;
    dict.set_item("values", values)?;
    Ok(dict)
}

impl CampaignObserver for CampaignWatch {
    fn progress(&self, progress: &CampaignProgress) {
        let Some(function) = &self.on_progress else { return };
        if self.stopped.load(Ordering::Relaxed) {
            return;
        }
        let is_due = {
            let mut kept = self.kept();
            let is_due =
                kept.told.is_none_or(|told| told.elapsed() >= EVERY) || progress.finished == progress.runs;
            if is_due {
                kept.told = Some(Instant::now());
            }
            is_due
        };
        if is_due {
            let answer = Python::try_attach(|py| {
                let answer = function.bind(py).call1((object(py, progress)?,))?;
                Ok(answer.extract::<bool>().unwrap_or(true))
            });
            self.after(answer);
        }
    }

    fn warn(&self, text: &str) {
        self.kept().warnings.push(text.to_string());
    }

    fn flow(&self) -> Flow {
        let is_due = {
            let mut kept = self.kept();
            let is_due = kept.asked.elapsed() >= EVERY;
            if is_due {
                kept.asked = Instant::now();
            }
            is_due
        };
        if is_due && !self.stopped.load(Ordering::Relaxed) {
            self.after(Python::try_attach(|py| py.check_signals().map(|()| true)));
        }
        if self.stopped.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
    }
}
