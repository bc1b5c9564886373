//! The trait of engines, and the [`Laboratory`] whose cases they execute. A laboratory owns a registry of engines and passes
//! itself to the engine that executes a case: these types refer to each other and are therefore defined together.

use std::sync::Arc;
use std::time::Duration;

use granum_core::names::suggestion;
use granum_dem::observer::Observer;
use granum_dem::simulation::Hardware;
use granum_io::Case;
use granum_io::run::{Machine, RunFolder, RunRecord};

use super::engine_error::EngineError;
use crate::laboratory::laboratory_error::LaboratoryError;
use crate::laboratory::shared::Shared;
use crate::laboratory::source::Source;
use crate::registry::Registry;

/// Makes samples and tests them.
///
/// ```
/// use granum_run::Laboratory;
///
/// let laboratory = Laboratory { grains_per_thread: 1, ..Laboratory::here() };
/// assert_eq!(laboratory.engine, "granum");
/// assert!(laboratory.registry.vocabulary.sensors().named("overlap_distribution").is_ok());
/// ```
#[derive(Clone, Debug)]
pub struct Laboratory {
    /// Threads and instruction set of the simulations; results do not depend on them.
    pub hardware: Hardware,
    /// Smallest number of grains for each thread; with 1, all threads of `hardware` are used.
    pub grains_per_thread: usize,
    /// The other runs with which a run shares the processors, if there are any.
    pub shared: Option<Arc<Shared>>,
    /// Wall time between two checkpoints; results do not depend on it.
    pub checkpoint_every: Duration,
    /// Version of granum for the records.
    pub version: String,
    /// Name of the engine that executes cases.
    pub engine: String,
    /// What is known by name: laws, paths, sensors, formats, engines.
    pub registry: Registry,
}

impl Laboratory {
    /// The threads and instruction set for a simulation of a number of grains, given the runs that share the processors at present.
    pub(crate) fn hardware_for(&self, grains: usize) -> Hardware {
        let running = self.shared.as_ref().map_or(1, |s| s.running().max(1));
        let useful = grains / self.grains_per_thread.max(1);
        Hardware { threads: (self.hardware.threads / running).min(useful).max(1), ..self.hardware }
    }
}

/// The task of an engine.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Task<'a> {
    /// `prepare` for a sample only, `test` ([`granum_io::run::TEST`]) for a test.
    pub kind: &'a str,
    /// The case, which determines the result.
    pub case: &'a Case,
    /// The source of the sample.
    pub source: &'a Source,
    /// The laboratory: hardware, sensors, interval of checkpoints. It does not influence the result.
    pub laboratory: &'a Laboratory,
}

impl<'a> Task<'a> {
    /// A task of a laboratory.
    pub fn new(kind: &'a str, case: &'a Case, source: &'a Source, laboratory: &'a Laboratory) -> Task<'a> {
        Task { kind, case, source, laboratory }
    }

    /// The initial record of a run of this task by an engine.
    ///
    /// # Errors
    /// If the file of the sample cannot be read.
    pub fn record(&self, engine: &dyn Engine) -> Result<RunRecord, LaboratoryError> {
        let Laboratory { hardware, version, .. } = self.laboratory;
        let machine = Machine::here(hardware.isa.name(), hardware.threads);
        let mut record = RunRecord::new(self.kind, version, self.case, machine);
        record.engine = engine.name().to_string();
        record.source = self.source.record()?;
        Ok(record)
    }
}

/// The work of a [`PlannedRun`] in the folder of its run.
type Work<'a> = dyn FnOnce(&RunFolder, &mut dyn Observer) -> Result<RunRecord, LaboratoryError> + 'a;

/// A run whose inputs have been checked and which has not written anything yet.
pub struct PlannedRun<'a>(Box<Work<'a>>);

impl<'a> PlannedRun<'a> {
    /// A run that calls `work` with its folder.
    pub fn new(
        work: impl FnOnce(&RunFolder, &mut dyn Observer) -> Result<RunRecord, LaboratoryError> + 'a,
    ) -> PlannedRun<'a> {
        PlannedRun(Box::new(work))
    }

    /// Executes the run until its end, or until the observer stops it.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn run(self, folder: &RunFolder, observer: &mut dyn Observer) -> Result<RunRecord, LaboratoryError> {
        (self.0)(folder, observer)
    }
}

/// An engine executes a case and writes a run folder: `case.toml`, `series.parquet`, `forces.parquet`, `run.json`.
///
/// ```
/// use granum_dem::observer::{NoObserver, Observer};
/// use granum_io::{Case, RunFolder, RunStatus};
/// use granum_run::{PlannedRun, Engine, Laboratory, LaboratoryError, Registry, Source, Task};
///
/// /// Reproduces the record of an earlier run.
/// struct Replay(std::path::PathBuf);
///
/// impl Engine for Replay {
///     fn name(&self) -> &'static str {
///         "replay"
///     }
///     fn help(&self) -> &'static str {
///         "the record of a run that was made before"
///     }
///     fn begin<'a>(&'a self, task: Task<'a>, _: &mut dyn Observer) -> Result<PlannedRun<'a>, LaboratoryError> {
///         // Invalid tasks are refused here, before a folder is created.
///         let recorded = granum_io::Run::at(&self.0)?;
///         let mut record = task.record(self)?;
///         Ok(PlannedRun::new(move |folder, _| {
///             folder.write_case(task.case, None)?;
///             folder.write_series(&recorded.series()?)?;
///             folder.write_forces(&recorded.forces()?)?;
///             record.status = RunStatus::Finished;
///             folder.write_record(&record)?;
///             Ok(record)
///         }))
///     }
/// }
///
/// # let case = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
/// #             shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2";
/// # let case = Case::parse(case, "case")?;
/// # let base = tempfile::tempdir()?;
/// let first = RunFolder::create(base.path().join("first"), false)?;
/// Laboratory::here().shear(&case, &Source::Case, &first, &mut NoObserver)?;
///
/// let registry = Registry::standard().with_engine(Replay(first.path().to_path_buf()))?;
/// let laboratory = Laboratory { engine: "replay".into(), ..Laboratory::here().with_registry(registry) };
/// let again = RunFolder::create(base.path().join("again"), false)?;
/// let record = laboratory.shear(&case, &Source::Case, &again, &mut NoObserver)?;
/// assert_eq!(record.engine, "replay");
/// assert_eq!(again.run().series()?, first.run().series()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Engine: Send + Sync {
    /// Name of the engine, which is stored in the record of a run.
    fn name(&self) -> &'static str;

    /// A short description of the engine.
    fn help(&self) -> &'static str;

    /// Reads and checks the inputs of a run, and refuses what this engine cannot execute. Nothing is written, so that a
    /// mistake leaves no folder behind.
    ///
    /// # Errors
    /// If the case or the sample is invalid, or the computer is not sufficient.
    fn begin<'a>(
        &'a self,
        task: Task<'a>,
        observer: &mut dyn Observer,
    ) -> Result<PlannedRun<'a>, LaboratoryError>;

    /// Executes a task in a folder until its end, or until the observer stops it.
    ///
    /// # Errors
    /// As [`Engine::begin`] and [`PlannedRun::run`].
    fn run(
        &self,
        task: Task,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        self.begin(task, observer)?.run(folder, observer)
    }

    /// Resumes a run that was interrupted, was killed or failed.
    ///
    /// # Errors
    /// [`EngineError::CannotResume`] unless the engine supports it.
    fn resume(
        &self,
        laboratory: &Laboratory,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        let _ = (laboratory, folder, observer);
        Err(EngineError::CannotResume { engine: self.name() }.into())
    }
}

/// The registry of the engines of a program.
///
/// ```
/// let engines = granum_run::Engines::standard();
/// assert_eq!(engines.names().collect::<Vec<_>>(), ["granum"]);
/// let error = engines.named("gramun").err().map(|error| error.to_string());
/// assert_eq!(error.as_deref(), Some("there is no engine \"gramun\"; did you mean granum?"));
/// ```
#[derive(Clone)]
pub struct Engines(pub(super) Vec<Arc<dyn Engine>>);

impl Engines {
    /// Adds an engine.
    ///
    /// # Errors
    /// [`EngineError::NameTaken`] if there is already an engine of the same name.
    pub fn with(mut self, engine: impl Engine + 'static) -> Result<Engines, EngineError> {
        let name = engine.name();
        if self.names().any(|known| known == name) {
            return Err(EngineError::NameTaken { name });
        }
        self.0.push(Arc::new(engine));
        Ok(self)
    }

    /// Their names.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.0.iter().map(|engine| engine.name())
    }

    /// The engine of the given name.
    ///
    /// # Errors
    /// [`EngineError::Unknown`] with the most similar name.
    pub fn named(&self, name: &str) -> Result<&dyn Engine, EngineError> {
        let found = self.0.iter().find(|engine| engine.name() == name);
        found.map(|engine| &**engine).ok_or_else(|| EngineError::Unknown {
            name: name.to_string(),
            suggestion: suggestion(name, self.names()),
        })
    }
}

impl std::fmt::Debug for Engines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}
