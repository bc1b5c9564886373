//! The trait of engines.

use granum_dem::observer::SimulationObserver;
use granum_io::case::Vocabulary;
use granum_io::run::RunRecord;
use granum_io::{Case, RunFolder};

use super::engine_run::EngineRun;
use crate::task::definition::Task;
use crate::task::engine_error::EngineError;
use crate::task::laboratory_error::LaboratoryError;

/// An engine computes a sample or a test. It gets a [`Task`], and puts what it finds into a [`Sink`](crate::task::sink::Sink): the
/// states as they come, the measurements, snapshots, a checkpoint or restart files of its own, and the record of the run.
///
/// ```
/// use granum_dem::observer::{NoObserver, SimulationObserver};
/// use granum_io::{Case, RunFolder, RunKind};
/// use granum_run::record::read_record;
/// use granum_run::{Engine, EngineError, EngineRun, Laboratory, LaboratoryError, RunRegistry, Source, Task};
///
/// /// Reproduces the measurements of an earlier run.
/// struct Replay(std::path::PathBuf);
///
/// impl Engine for Replay {
///     fn name(&self) -> &'static str {
///         "replay"
///     }
///     fn help(&self) -> &'static str {
///         "the measurements of a run that was made before"
///     }
///     fn plan(&self, task: Task, _: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError> {
///         // What this engine cannot do is refused here, before a folder is created.
///         if task.kind == RunKind::Sample {
///             let what = "it makes no samples; use the engine granum".to_string();
///             return Err(EngineError::Refused { engine: self.name().into(), what }.into());
///         }
///         let recorded = read_record(&granum_io::Run::at(&self.0)?)?;
///         Ok(EngineRun::new(task.record()?, move |sink, _| Ok(sink.save_measurements(&recorded)?)))
///     }
/// }
///
/// # let case = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
/// #             shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2";
/// # let case = Case::parse(case, "case")?;
/// # let base = tempfile::tempdir()?;
/// let first = RunFolder::create(base.path().join("first"), false)?;
/// Laboratory::here().run(RunKind::Test, &case, &Source::Case, &first, &mut NoObserver)?;
///
/// let registry = RunRegistry::standard().with_engine(Replay(first.path().to_path_buf()))?;
/// let laboratory = Laboratory { engine: "replay".into(), ..Laboratory::here().with_registry(registry) };
/// let again = RunFolder::create(base.path().join("again"), false)?;
/// let record = laboratory.run(RunKind::Test, &case, &Source::Case, &again, &mut NoObserver)?;
/// assert_eq!(record.engine, "replay");
/// assert_eq!(again.run().series()?, first.run().series()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Engine: Send + Sync {
    /// Name of the engine, which is stored in the record of a run.
    fn name(&self) -> &'static str;

    /// A short description of the engine.
    fn help(&self) -> &'static str;

    /// Version of the engine for the record, such as that of a program which it starts; empty for one that is a part of granum.
    ///
    /// # Errors
    /// If the engine cannot be found.
    fn version(&self) -> Result<String, EngineError> {
        Ok(String::new())
    }

    /// True if it prepares samples; for an engine that does not, granum's own prepares them.
    fn makes_samples(&self) -> bool {
        true
    }

    /// Refuses a case that this engine cannot test, whatever its sample. With it the runs of a campaign are checked before there are samples.
    ///
    /// # Errors
    /// [`EngineError::Refused`] with the key of the case, or [`LaboratoryError`] with what else is wrong.
    fn check(&self, case: &Case, vocabulary: &Vocabulary) -> Result<(), LaboratoryError> {
        let _ = (case, vocabulary);
        Ok(())
    }

    /// Reads and checks the inputs of a run, refuses what this engine cannot execute ([`EngineError::Refused`]), and warns the observer
    /// of anything that the user should know. Nothing is written, so that a mistake leaves no folder behind.
    ///
    /// # Errors
    /// If the case or the sample is invalid, or the computer is not sufficient.
    fn plan(&self, task: Task, observer: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError>;

    /// Reads and checks what is needed to continue a run that was interrupted, was killed or failed; `None` if it is complete and
    /// nothing of it needs to be written again. `record` is that of the run.
    ///
    /// # Errors
    /// [`EngineError::CannotResume`] unless the engine supports it; if the contents of the folder cannot be used.
    fn resume(
        &self,
        task: Task,
        record: RunRecord,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Option<EngineRun>, LaboratoryError> {
        let _ = (task, record, folder, observer);
        Err(EngineError::CannotResume { engine: self.name().into() }.into())
    }
}
