//! The laboratory prepares samples, tests them, and writes run folders.
//!
//! ```text
//! Case --> plan --> run folder, or result in memory
//! ```

pub(crate) mod definition;
mod folder_sink;
pub mod limits;
mod memory_sink;
mod observed_packing;
mod planned_run;
mod run_result;

pub use crate::task::laboratory_error::LaboratoryError;
pub use crate::task::saved_run::SavedRun;
pub use crate::task::shared::{Entered, Shared};
pub use crate::task::source::Source;
pub use crate::task::status::{ProgressField, fields, fields_of_report, line};
pub use definition::Laboratory;
pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use observed_packing::observed_packing;
pub use planned_run::PlannedRun;
pub use run_result::RunResult;

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

pub use crate::task::{estimate, memory};
