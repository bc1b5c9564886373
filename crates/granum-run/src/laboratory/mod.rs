//! The laboratory: makes samples and tests them, and leaves run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```
//!
//! A run is a [`RunState`] that goes from stage to stage: preparation, sample, consolidation (where the test is at another
//! mean stress than the sample), test. It is written down as a
//! checkpoint at an interval of wall time and when the user stops it, and everything that decides what comes next is in
//! it: a run that is killed at any instant goes on to the same bits. Before the first checkpoint there are the case and
//! where the sample comes from.

mod consolidation;
mod follow;
mod from_packing;
mod in_memory;
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
pub use in_memory::TestResult;
pub use measures::late_mean;
pub use preparation_curve::PREPARATION_COLUMNS;
pub use run_state::check_beside;
pub use sample::{Source, cell, simulation, spheres};
pub use status::{Field, fields, line};

/// Name of the snapshot of a sample, in the folder of a test as it is when the test begins.
pub const SAMPLE: &str = "start";
/// Name of the snapshot at the end of a test.
pub const END: &str = "end";

/// Why a run failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LaboratoryError {
    /// A file or folder.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// The preparation.
    #[error(transparent)]
    Preparation(#[from] PreparationError),
    /// The engine.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A stage of the test.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// A sensor of the recording.
    #[error("recording.sensors: {0}")]
    Sensor(#[from] SensorError),
    /// The engine that was asked for.
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
    /// The machine cannot hold it.
    #[error(
        "{grains} grains need up to {needed:.1} GB of memory, and this machine has {available:.1} GB free: grains.count can be \
         at most {fitting} here"
    )]
    Memory {
        /// Grains asked for.
        grains: usize,
        /// Estimate, GB.
        needed: f64,
        /// Free, GB.
        available: f64,
        /// Grains that would fit.
        fitting: usize,
    },
    /// A packing that cannot be simulated.
    #[error("the packing cannot be simulated: {0}")]
    Packing(String),
    /// A checkpoint.
    #[error("{}: {what}", path.display())]
    Checkpoint {
        /// Its file.
        path: PathBuf,
        /// What is wrong, and what would be right.
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
        /// What is wrong with each.
        what: String,
    },
}

/// Processors that several runs share: a run that is alone gets all of them, many get one each.
#[derive(Debug, Default)]
pub struct Shared {
    running: AtomicUsize,
}

impl Shared {
    /// Counts a run in until the value returned is dropped.
    pub fn enter(self: &Arc<Self>) -> Entered {
        self.running.fetch_add(1, Ordering::Relaxed);
        Entered(self.clone())
    }
}

/// A run that counts.
pub struct Entered(Arc<Shared>);

impl Drop for Entered {
    fn drop(&mut self) {
        self.0.running.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Fewest grains that are worth a thread of their own.
pub const GRAINS_PER_THREAD: usize = 1500;
/// Wall time between two checkpoints, where nothing else is asked for.
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
    /// What runs the simulations; results do not depend on it.
    pub hardware: Hardware,
    /// Fewest grains for each thread; 1 to take as many threads as `hardware` says.
    pub grains_per_thread: usize,
    /// Set where several runs share the processors.
    pub shared: Option<Arc<Shared>>,
    /// Wall time between two checkpoints; results do not depend on it.
    pub checkpoint_every: Duration,
    /// Version to write into records.
    pub version: String,
    /// Name of the engine that runs cases.
    pub engine: String,
    /// The engines that are known.
    pub engines: Engines,
    /// The sensors that are known.
    pub sensors: Sensors,
    /// The formats of packings that are known.
    pub formats: Formats,
}

/// How a segment of a run ended.
enum Segment {
    /// There is more to do.
    GoOn,
    /// The observer wants to stop.
    Stop,
    /// The run is complete.
    Complete,
}

impl Laboratory {
    /// A laboratory of its own, with checkpoints at the usual interval.
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

    /// What to run a simulation of so many grains on just now.
    pub(crate) fn hardware_for(&self, grains: usize) -> Hardware {
        let running = self.shared.as_ref().map_or(1, |s| s.running.load(Ordering::Relaxed).max(1));
        let useful = grains / self.grains_per_thread.max(1);
        Hardware { threads: (self.hardware.threads / running).min(useful).max(1), ..self.hardware }
    }

    /// Makes a sample and leaves it in a folder: case, snapshot, checkpoint, record. The record's status tells whether it
    /// was interrupted.
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

    /// Makes or takes a sample and shears it as the case says; leaves a run folder.
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

    /// Reads what a run of a `kind` (`prepare`, `shear`) begins with and refuses what cannot be run. Nothing is written, so that
    /// a mistake leaves no folder behind. The observer is told what the user should know of it.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the machine cannot hold the case, or its sample or packing cannot be used.
    pub fn planned<'a>(
        &'a self,
        kind: &'a str,
        case: &'a Case,
        source: &'a Source,
        observer: &mut dyn Observer,
    ) -> Result<PlannedRun<'a>, LaboratoryError> {
        self.engine()?.begin(Task::new(kind, case, source, self), observer)
    }

    /// Goes on with a preparation or test that was interrupted, killed or failed: from its last good checkpoint, or from
    /// the case if there is none yet.
    ///
    /// # Errors
    /// [`LaboratoryError`] if what is there cannot be used, or it fails again.
    pub fn resume(
        &self,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        let engine = folder.run().record()?.engine;
        self.engines.named(&engine)?.resume(self, folder, observer)
    }

    /// The engine that runs cases.
    fn engine(&self) -> Result<&dyn Engine, EngineError> {
        self.engines.named(&self.engine)
    }

    /// The same laboratory with another engine, which runs its cases.
    ///
    /// # Errors
    /// [`EngineError::NameTaken`] if an engine of that name is known already.
    pub fn with_engine(mut self, engine: impl Engine + 'static) -> Result<Laboratory, EngineError> {
        self.engine = engine.name().to_string();
        self.engines = self.engines.with(engine)?;
        Ok(self)
    }

    /// The same laboratory with other formats, by which it reads packings.
    pub fn with_formats(self, formats: Formats) -> Laboratory {
        Laboratory { formats, ..self }
    }

    /// The same laboratory with one more sensor, which a case asks for by its name in `recording.sensors`.
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
