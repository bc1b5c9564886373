//! The laboratory prepares samples, tests them, and writes run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```

pub mod estimate;
mod in_folders;
mod in_memory;
pub(crate) mod laboratory_error;
pub mod limits;
pub mod memory;
pub(crate) mod setup;
pub(crate) mod shared;
pub(crate) mod source;
pub(crate) mod status;

pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use in_memory::{PreparedSample, TestResult};
pub use laboratory_error::LaboratoryError;
pub use setup::{CHECKPOINT_EVERY, GRAINS_PER_THREAD};
pub use shared::{Entered, Shared};
pub use source::Source;
pub use status::{Field, fields, line};

pub use crate::engine::engine_trait::Laboratory;
pub use crate::engine::native::{END, PREPARATION_COLUMNS, SAMPLE, cell, check_beside, simulation, spheres};
pub use crate::strength::late_mean;

#[cfg(test)]
mod earlier_version_tests;
#[cfg(test)]
mod interruption_tests;
#[cfg(test)]
mod tests;
