//! Runs of simulations: the [`laboratory`] prepares samples, tests them, and writes run folders from which an interrupted or
//! killed run can be resumed. The runs are executed by an [`engine`].
//!
//! ```text
//! Case --> Laboratory --> run folder: case, snapshots, checkpoint, record
//! ```

pub mod derived_columns;
pub mod digest;
pub mod engine;
pub mod laboratory;
pub mod lammps_deck;
pub mod queue;
pub mod record;
pub(crate) mod registry;
mod remark_on_shapes;
pub mod runs_table;
pub mod stiffness;
pub mod strength;
pub(crate) mod task;

pub use engine::{Engine, EngineError, EngineRun, Engines, Resources, Sink, Task};
pub use granum_core::observer::{Flow, NoObserver, Observer, Observers, Progress};
pub use granum_dem::observer::{
    EachProgress, SimulationObserver, SimulationObservers, SimulationProgress, Work,
};
pub use granum_io::RunKind;
pub use laboratory::{Laboratory, LaboratoryError, PlannedRun, RunResult, Source};
pub use registry::RunRegistry;
pub use remark_on_shapes::remark_on_shapes;

#[cfg(test)]
mod owned_tests;
