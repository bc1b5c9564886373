//! Runs: the [`laboratory`] makes samples and tests them and leaves run folders that survive a kill; an [`engine`] does the
//! work.
//!
//! ```text
//! Case --> Laboratory --> run folder: case, snapshots, checkpoint, record
//! ```

pub mod engine;
pub mod laboratory;
pub mod record;

pub use engine::{Engine, EngineError, Engines, PlannedRun, Task};
pub use granum_dem::observer::{Flow, NoObserver, Observer, Observers, Progress};
pub use laboratory::{Laboratory, LaboratoryError, Source, TestResult};
