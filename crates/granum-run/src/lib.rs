//! Runs: the [`laboratory`] makes samples and tests them and leaves run folders that survive a kill.
//!
//! ```text
//! Case --> Laboratory --> run folder: case, snapshots, checkpoint, record
//! ```

pub mod laboratory;
pub mod record;

pub use laboratory::{Laboratory, LaboratoryError, Nobody, RunObserver, Source, Status, TestResult};
