//! The laboratory prepares samples, tests them, and writes run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```
//!
//! A run is a [`RunState`] that passes through these stages: preparation, sample, consolidation (if the mean stress of the
//! test differs from that of the sample), test. The state is written to a checkpoint at intervals of wall time and when the
//! user stops the run. The checkpoint contains everything that determines how the run continues, so that a run can be killed
//! at any instant and, when resumed, gives results that are identical bit by bit. Before the first checkpoint, the run is
//! defined by the case and the source of the sample.

mod consolidation;
mod follow;
mod from_packing;
mod in_memory;
pub mod limits;
mod measures;
pub mod memory;
mod pace;
mod preparation_curve;
mod quality;
pub(crate) mod run;
mod run_state;
mod sample;
mod saved_state;
mod status;
mod store;
mod test;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use granum_dem::loading::ControlError;
use granum_dem::observer::Observer;
use granum_dem::preparation::PreparationError;
use granum_dem::simulation::{Hardware, SimulationError};
use granum_io::run::{RunFolder, RunRecord};
use granum_io::shell::quoted_path;
use granum_io::{Case, Formats};
use granum_sensors::{Sensor, SensorError, Sensors};
use thiserror::Error;

use crate::engine::native::Native;
use crate::engine::{Engine, EngineError, Engines, PlannedRun, Task};

use self::pace::Interval;
use self::status::Speedometer;
use self::store::Store;
use self::test::Test;

pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use in_memory::{PreparedSample, TestResult};
pub use measures::late_mean;
pub use preparation_curve::PREPARATION_COLUMNS;
pub use run_state::check_beside;
pub use sample::{Source, cell, simulation, spheres};
pub use status::{Field, fields, line};

/// Name of the snapshot of a sample; in the folder of a test it holds the state in which the test begins.
pub const SAMPLE: &str = "start";
/// Name of the snapshot at the end of a test.
pub const END: &str = "end";

/// Why a run failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LaboratoryError {
    /// A file or folder cannot be read or written.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// The preparation failed.
    #[error(transparent)]
    Preparation(#[from] PreparationError),
    /// The simulation failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A stage of the test failed.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A sensor of the recording cannot be used.
    #[error("recording.sensors: {0}")]
    Sensor(#[from] SensorError),
    /// The requested engine cannot be used.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// A state that stages go back to cannot be kept or used.
    #[error("the state that later stages go back to: {0}")]
    Kept(String),
    /// No stage kept a state.
    #[error("the stage {stage} goes back to a state, but no stage before it kept one (start = \"kept\")")]
    NothingKept {
        /// Name of the stage.
        stage: String,
    },
    /// The run does not fit into the available memory.
    #[error(
        "{grains} grains need up to {needed:.1} GB of memory, and this machine has {available:.1} GB free: grains.count can be \
         at most {fitting} here"
    )]
    Memory {
        /// Number of grains of the case.
        grains: usize,
        /// Estimate of the memory that they need, GB.
        needed: f64,
        /// Free memory, GB.
        available: f64,
        /// Number of grains that would fit.
        fitting: usize,
    },
    /// A packing that cannot be simulated.
    #[error("the packing cannot be simulated: {0}")]
    Packing(String),
    /// A checkpoint cannot be used or written.
    #[error("{}: {what}", path.display())]
    Checkpoint {
        /// The file of the checkpoint.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        what: String,
    },
    /// No checkpoint of a folder can be used.
    #[error(
        "{what}: no checkpoint can be used; run it again, e.g. `granum shear {} --out OTHER`",
        quoted_path(&folder.join("case.toml"))
    )]
    Unusable {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with each checkpoint.
        what: String,
    },
}

/// The processors that several runs share: a single run gets all of them, and many runs get one each.
#[derive(Debug, Default)]
pub struct Shared {
    running: AtomicUsize,
}

impl Shared {
    /// Registers a run until the returned value is dropped.
    pub fn enter(self: &Arc<Self>) -> Entered {
        self.running.fetch_add(1, Ordering::Relaxed);
        Entered(self.clone())
    }
}

/// The registration of a run that shares the processors; dropping it ends the registration.
pub struct Entered(Arc<Shared>);

impl Drop for Entered {
    fn drop(&mut self) {
        self.0.running.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Smallest number of grains for which a thread of its own is worthwhile.
pub const GRAINS_PER_THREAD: usize = 1500;
/// Default wall time between two checkpoints.
pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);

/// Makes samples and tests them.
///
/// ```
/// use granum_run::Laboratory;
///
/// let laboratory = Laboratory { grains_per_thread: 1, ..Laboratory::here() };
/// assert_eq!(laboratory.engine, "granum");
/// assert!(laboratory.sensors.named("overlap_distribution").is_ok());
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
    /// The registry of engines.
    pub engines: Engines,
    /// The registry of sensors.
    pub sensors: Sensors,
    /// The formats of packings that are known.
    pub formats: Formats,
}

/// The way in which a segment of a run ended.
enum Segment {
    /// The run continues with the next segment.
    GoOn,
    /// The observer stopped the run.
    Stop,
    /// The run is complete.
    Complete,
}

impl Laboratory {
    /// A laboratory that shares its processors with no other run and writes checkpoints at the default interval.
    pub fn new(hardware: Hardware, version: impl Into<String>) -> Laboratory {
        Laboratory {
            hardware,
            grains_per_thread: GRAINS_PER_THREAD,
            shared: None,
            checkpoint_every: CHECKPOINT_EVERY,
            version: version.into(),
            engine: Native.name().to_string(),
            engines: Engines::standard(),
            sensors: Sensors::standard(),
            formats: Formats::standard(),
        }
    }

    /// The threads and instruction set for a simulation of so many grains, given the runs that share the processors now.
    pub(crate) fn hardware_for(&self, grains: usize) -> Hardware {
        let running = self.shared.as_ref().map_or(1, |s| s.running.load(Ordering::Relaxed).max(1));
        let useful = grains / self.grains_per_thread.max(1);
        Hardware { threads: (self.hardware.threads / running).min(useful).max(1), ..self.hardware }
    }

    /// Prepares a sample and writes it to a folder: case, snapshot, checkpoint, record. The status in the record states
    /// whether the preparation was interrupted.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn prepare(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        self.engine()?.run(Task::new("prepare", case, source, self), folder, observer)
    }

    /// Prepares or reads a sample and tests it as the case specifies; writes a run folder.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn shear(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        self.engine()?.run(Task::new("shear", case, source, self), folder, observer)
    }

    /// Reads and checks the inputs of a run of a `kind` (`prepare`, `shear`), and warns the observer of anything that the
    /// user should know. Nothing is written, so that a mistake leaves no folder behind.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the case does not fit into memory, or if its sample or packing cannot be used.
    pub fn planned<'a>(
        &'a self,
        kind: &'a str,
        case: &'a Case,
        source: &'a Source,
        observer: &mut dyn Observer,
    ) -> Result<PlannedRun<'a>, LaboratoryError> {
        self.engine()?.begin(Task::new(kind, case, source, self), observer)
    }

    /// Resumes a preparation or test that was interrupted, was killed or failed, from its last usable checkpoint, or from
    /// the case if there is no checkpoint yet.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the contents of the folder cannot be used, or if the run fails again.
    pub fn resume(
        &self,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        let engine = folder.run().record()?.engine;
        self.engines.named(&engine)?.resume(self, folder, observer)
    }

    /// The engine that executes cases.
    fn engine(&self) -> Result<&dyn Engine, EngineError> {
        self.engines.named(&self.engine)
    }

    /// Adds an engine and selects it for the execution of cases.
    ///
    /// # Errors
    /// [`EngineError::NameTaken`] if there is already an engine of the same name.
    pub fn with_engine(mut self, engine: impl Engine + 'static) -> Result<Laboratory, EngineError> {
        self.engine = engine.name().to_string();
        self.engines = self.engines.with(engine)?;
        Ok(self)
    }

    /// The same laboratory with other formats, by which it reads packings.
    pub fn with_formats(self, formats: Formats) -> Laboratory {
        Laboratory { formats, ..self }
    }

    /// Adds a sensor, which a case requests by its name in `recording.sensors`.
    ///
    /// # Errors
    /// As [`Sensors::with`].
    pub fn with_sensor(mut self, sensor: impl Sensor + 'static) -> Result<Laboratory, SensorError> {
        self.sensors = self.sensors.with(sensor)?;
        Ok(self)
    }
}

#[cfg(test)]
mod interruption_tests;
#[cfg(test)]
mod tests;
