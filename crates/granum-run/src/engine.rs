//! An [`Engine`] executes the run of a case. The engine of granum is [`Native`](native::Native); a new one needs a file in
//! this folder and a line in [`Engines::standard`], and a program can add its own engine with [`Engines::with`].

pub mod native;

use std::sync::Arc;

use granum_core::names::suggestion;
use granum_dem::observer::Observer;
use granum_io::Case;
use granum_io::run::{Machine, RunFolder, RunRecord};

use crate::laboratory::{Laboratory, LaboratoryError, Source};

/// The task of an engine.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Task<'a> {
    /// `prepare` for a sample only, `shear` for a test.
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
/// use granum_run::{PlannedRun, Engine, Laboratory, LaboratoryError, Source, Task};
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
/// let laboratory = Laboratory::here().with_engine(Replay(first.path().to_path_buf()))?;
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

/// The reason why an engine cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// There is none of that name.
    #[error("there is no engine {name:?}; {suggestion}")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest name, or all existing names.
        suggestion: String,
    },
    /// There is already an engine of the same name.
    #[error("there is already an engine {name:?}: give the new one another name")]
    NameTaken {
        /// The name.
        name: &'static str,
    },
    /// The engine cannot resume runs.
    #[error(
        "the engine {engine} cannot go on with a run that was interrupted: run it again in another folder"
    )]
    CannotResume {
        /// Its name.
        engine: &'static str,
    },
    /// The engine failed.
    #[error("the engine {engine}: {what}")]
    Failed {
        /// Its name.
        engine: &'static str,
        /// What is wrong, and what would be right.
        what: String,
    },
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
pub struct Engines(Vec<Arc<dyn Engine>>);

impl Engines {
    /// The formats that come with granum.
    pub fn standard() -> Engines {
        Engines(vec![Arc::new(native::Native)])
    }

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

#[cfg(test)]
mod tests {
    use granum_dem::observer::NoObserver;
    use granum_io::RunStatus;

    use super::*;

    /// Writes a case and a record, and no more.
    struct Clerk;
    impl Engine for Clerk {
        fn name(&self) -> &'static str {
            "clerk"
        }
        fn help(&self) -> &'static str {
            "writes down what it is asked for"
        }
        fn begin<'a>(
            &'a self,
            task: Task<'a>,
            observer: &mut dyn Observer,
        ) -> Result<PlannedRun<'a>, LaboratoryError> {
            if task.kind != "shear" {
                let what = "it makes no samples; use the engine granum".to_string();
                return Err(EngineError::Failed { engine: self.name(), what }.into());
            }
            observer.warn("nothing is simulated");
            let mut record = task.record(self)?;
            Ok(PlannedRun::new(move |folder, _| {
                folder.write_case(task.case, None)?;
                record.status = RunStatus::Interrupted;
                folder.write_record(&record)?;
                Ok(record)
            }))
        }
    }

    #[test]
    fn an_engine_of_ones_own_runs_the_cases_of_a_laboratory() {
        let base = tempfile::tempdir().unwrap();
        let laboratory = Laboratory::here().with_engine(Clerk).unwrap();
        let folder = RunFolder::create(base.path().join("run"), false).unwrap();
        let record = laboratory.shear(&Case::default(), &Source::Case, &folder, &mut NoObserver).unwrap();
        assert_eq!((record.engine.as_str(), record.status), ("clerk", RunStatus::Interrupted));
        assert_eq!(folder.run().record().unwrap(), record);
        assert_eq!(folder.run().case().unwrap(), Case::default());

        // What it refuses, it refuses before there is a folder.
        let case = Case::default();
        let begun = laboratory.planned("prepare", &case, &Source::Case, &mut NoObserver);
        let message = begun.err().unwrap().to_string();
        assert_eq!(message, "the engine clerk: it makes no samples; use the engine granum");
        // The record says whose run it is, so that the right engine is asked to go on with it.
        let message = laboratory.resume(&folder, &mut NoObserver).unwrap_err().to_string();
        assert!(message.starts_with("the engine clerk cannot go on with a run"), "{message}");
        let message = Laboratory::here().resume(&folder, &mut NoObserver).unwrap_err().to_string();
        assert_eq!(message, "there is no engine \"clerk\"; there are: granum");
        assert_eq!(laboratory.with_engine(Clerk).err(), Some(EngineError::NameTaken { name: "clerk" }));
    }

    #[test]
    fn a_sensor_that_is_not_known_is_refused_before_there_is_a_folder() {
        let mut case = Case::default();
        case.grains.count = 60;
        case.recording.sensors = vec!["overlap_distributon".into()];
        let laboratory = Laboratory::here();
        let begun = laboratory.planned("shear", &case, &Source::Case, &mut NoObserver);
        let message = begun.err().unwrap().to_string();
        let wanted = "there is no sensor \"overlap_distributon\"; did you mean overlap_distribution?";
        assert_eq!(message, format!("recording.sensors: {wanted}"));
    }
}
