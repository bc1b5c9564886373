//! The laboratory prepares samples, tests them, and writes run folders.
//!
//! ```text
//! Case --> plan --> run folder, or result in memory
//! ```

pub(crate) mod definition;
pub mod estimate;
mod folder_sink;
pub(crate) mod laboratory_error;
pub mod limits;
pub mod memory;
mod memory_sink;
mod observed_packing;
mod planned_run;
mod run_result;
pub(crate) mod saved_run;
pub(crate) mod shared;
pub(crate) mod source;
pub(crate) mod status;

pub use definition::Laboratory;
pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use laboratory_error::LaboratoryError;
pub use observed_packing::observed_packing;
pub use planned_run::PlannedRun;
pub use run_result::RunResult;
pub use saved_run::SavedRun;
pub use shared::{Entered, Shared};
pub use source::Source;
pub use status::{ProgressField, fields, fields_of_report, line};

pub use crate::engine::native::{
    END, PREPARATION_COLUMNS, RunInPieces, SAMPLE, cell, check_beside, simulation, spheres,
};
pub use crate::engine::{CHECKPOINT_EVERY, GRAINS_PER_THREAD};
pub use crate::strength::late_mean;

#[cfg(test)]
mod earlier_version_tests;
#[cfg(test)]
mod interruption_tests;
#[cfg(test)]
mod tests;
