//! Why a run failed.

use std::path::PathBuf;

use granum_dem::loading::ControlError;
use granum_dem::preparation::PreparationError;
use granum_dem::simulation::SimulationError;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_sensors::SensorError;
use thiserror::Error;

use crate::task::engine_error::EngineError;

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
    /// A state to which stages return cannot be saved or restored.
    #[error("the state to which later stages go back: {0}")]
    Kept(String),
    /// No stage has saved a state.
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
    #[error("{}: {what}", path.shown())]
    Checkpoint {
        /// The file of the checkpoint.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        what: String,
    },
    /// A file of a run was changed or removed, and the run cannot write it again.
    #[error(
        "{what}; the run cannot write it again from its checkpoint: put the file back, or run the case again with --force"
    )]
    Damaged {
        /// The file, and what is wrong.
        what: String,
    },
    /// The observer stopped the run before its end.
    #[error("stopped during the {phase}")]
    Stopped {
        /// The phase of the run.
        phase: String,
    },
    /// No checkpoint of a folder can be used.
    #[error(
        "{what}: no checkpoint can be used; run it again, e.g. `granum run {} --out OTHER`",
        quoted_path(&folder.join("case.toml"))
    )]
    Unusable {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with each checkpoint.
        what: String,
    },
}
