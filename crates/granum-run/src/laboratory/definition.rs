//! The laboratory: it plans, executes and resumes runs with the engines that it knows.

use std::path::Path;

use granum_dem::observer::{NoObserver, SimulationObserver};
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::run::{OWN_ENGINE, RunFolder, RunKind, RunRecord, RunStatus};
use granum_io::{Case, Error as FileError};

use super::folder_sink::FolderSink;
use super::planned_run::{FAILED, PlannedRun, finish, write_case};
use super::run_result::RunResult;
use crate::engine::engine_trait::Engine;
use crate::engine::native::{self, Native, RunInPieces};
use crate::registry::RunRegistry;
use crate::task::definition::Task;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::resources::Resources;
use crate::task::source::Source;

/// Makes samples and tests them.
///
/// ```
/// use granum_run::{Laboratory, Resources};
///
/// let resources = Resources { grains_per_thread: 1, ..Resources::here() };
/// let laboratory = Laboratory { resources, ..Laboratory::here() };
/// assert_eq!(laboratory.engine, "granum");
/// assert!(laboratory.registry.vocabulary.sensors().named("overlap_distribution").is_ok());
/// ```
#[derive(Clone, Debug)]
pub struct Laboratory {
    /// What its runs may use of the computer; results do not depend on it.
    pub resources: Resources,
    /// Version of granum for the records.
    pub version: String,
    /// Name of the engine that executes cases.
    pub engine: String,
    /// What is known by name: laws, paths, sensors, formats, engines.
    pub registry: RunRegistry,
}

impl Laboratory {
    /// A laboratory that shares its processors with no other run and writes checkpoints at the default interval.
    pub fn new(hardware: Hardware, version: impl Into<String>) -> Laboratory {
        Laboratory {
            resources: Resources::new(hardware),
            version: version.into(),
            engine: Native.name().to_string(),
            registry: RunRegistry::standard(),
        }
    }

    /// A laboratory that uses all processors of this computer.
    pub fn here() -> Laboratory {
        Laboratory::new(Resources::here().hardware, env!("CARGO_PKG_VERSION"))
    }

    /// The same laboratory with other laws, paths, sensors, formats and engines.
    pub fn with_registry(self, registry: impl Into<RunRegistry>) -> Laboratory {
        Laboratory { registry: registry.into(), ..self }
    }

    /// The name of the engine that executes runs of a kind: that of the laboratory, or granum's own for samples if that prepares none.
    ///
    /// # Errors
    /// [`LaboratoryError::Engine`] if there is no engine of that name.
    pub fn engine_for(&self, kind: RunKind) -> Result<&str, LaboratoryError> {
        let engine = self.registry.engines.named(&self.engine)?;
        Ok(if kind == RunKind::Sample && !engine.makes_samples() { OWN_ENGINE } else { &self.engine })
    }

    /// An engine by its name.
    pub(crate) fn engine(&self, name: &str) -> Result<&dyn Engine, LaboratoryError> {
        Ok(self.registry.engines.named(name)?)
    }

    /// Reads and checks the inputs of a run, and warns the observer of anything that the user should know. Nothing is written,
    /// so that a mistake leaves no folder behind. What is planned is executed in a folder or in memory.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the case does not fit into memory, if its sample or packing cannot be used, or if the engine refuses
    /// it.
    pub fn plan(
        &self,
        kind: RunKind,
        case: &Case,
        source: &Source,
        observer: &mut dyn SimulationObserver,
    ) -> Result<PlannedRun, LaboratoryError> {
        let engine = self.engine(self.engine_for(kind)?)?;
        let mut run = engine.plan(self.task(engine, kind, case.clone(), source.clone()), observer)?;
        run.record.engine_version = engine.version()?;
        Ok(PlannedRun { case: case.clone(), run })
    }

    /// Reads and checks the inputs of a run of granum's own engine that goes on a piece at a time, in memory.
    ///
    /// # Errors
    /// As [`Laboratory::plan`].
    pub fn in_pieces(
        &self,
        kind: RunKind,
        case: &Case,
        source: &Source,
        observer: &mut dyn SimulationObserver,
    ) -> Result<RunInPieces, LaboratoryError> {
        RunInPieces::new(&self.task(&Native, kind, case.clone(), source.clone()), observer)
    }

    /// Makes a sample, or tests one, and writes a run folder: case, snapshots, checkpoint, measurements, record. The status in the
    /// record says whether the run was interrupted.
    ///
    /// # Errors
    /// As [`Laboratory::plan`] and [`PlannedRun::in_folder`].
    pub fn run(
        &self,
        kind: RunKind,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        self.plan(kind, case, source, observer)?.in_folder(folder, observer)
    }

    /// Prepares the sample of a case and tests it; no files are written. It is short for [`Laboratory::plan`] and
    /// [`PlannedRun::in_memory`].
    ///
    /// ```
    /// use granum_io::Case;
    /// use granum_run::Laboratory;
    ///
    /// let case = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
    ///             shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2";
    /// let test = Laboratory::here().test(&Case::parse(case, "case")?)?;
    /// assert_eq!(test.record.series.rows(), 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`LaboratoryError`] if the case cannot be run, or the run fails.
    pub fn test(&self, case: &Case) -> Result<RunResult, LaboratoryError> {
        self.plan(RunKind::Test, case, &Source::Case, &mut NoObserver)?.in_memory(&mut NoObserver)
    }

    /// Resumes a run that was interrupted, was killed or failed, with the engine that began it, from its last usable checkpoint, or
    /// from the case if there is no checkpoint yet.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the contents of the folder cannot be used, or if the run fails again.
    pub fn resume(
        &self,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        let run = folder.run().with_vocabulary(&self.registry.vocabulary);
        let mut record = run.record()?;
        let engine = self.engine(&record.engine)?;
        let case = run.case()?;
        if !record.is_of(&case) {
            let message = "the case was changed since the run began; run the changed case in another folder";
            return Err(FileError::content(&folder.path().join("case.toml"), message).into());
        }
        // Which sample the run had is in its record.
        let task = self.task(engine, record.kind, case.clone(), Source::Case);
        let Some(run) = engine.resume(task, record.clone(), folder, observer)? else { return Ok(record) };
        // A run that goes on is past what ended it before.
        record.notes.retain(|note| !note.starts_with(FAILED));
        if record.granum_version != self.version {
            let (old, new) = (&record.granum_version, &self.version);
            let text = format!(
                "started with granum {old} and resumed with {new}: its results may differ in the last digits from those of \
                 either version"
            );
            observer.warn(&text);
            record.notes.push(text);
        }
        record.status = RunStatus::Running;
        finish(folder, record, |record| {
            if record.unwritten_case.take().is_some() {
                write_case(folder, &case, record)?;
            }
            run.run(&mut FolderSink::new(folder, record), observer)
        })
    }

    /// The simulation at the last checkpoint of a folder that granum's own engine wrote: of a finished preparation or test its end.
    ///
    /// # Errors
    /// [`LaboratoryError::Checkpoint`] if there is none or it cannot be used.
    pub fn last_state(&self, folder: &Path) -> Result<Simulation, LaboratoryError> {
        native::last_state(folder, &self.registry.vocabulary, &self.resources)
    }

    fn task(&self, engine: &dyn Engine, kind: RunKind, case: Case, source: Source) -> Task {
        Task {
            kind,
            case,
            source,
            engine: engine.name().to_string(),
            version: self.version.clone(),
            resources: self.resources.clone(),
            vocabulary: self.registry.vocabulary.clone(),
            formats: self.registry.formats.clone(),
        }
    }
}
