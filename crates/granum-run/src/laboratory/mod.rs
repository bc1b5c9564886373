//! The laboratory prepares samples, tests them, and writes run folders.
//!
//! ```text
//! Case --> prepare --> sample folder --> shear --> run folder
//! ```
//!
//! A run is a `RunState` that passes through these stages: preparation, sample, consolidation (if the mean stress of the
//! test differs from that of the sample), test. The state is written to a checkpoint at intervals of wall time and when the
//! user stops the run. The checkpoint contains everything that determines how the run continues, so that a run can be killed
//! at any instant and, when resumed, gives results that are identical bit by bit. Before the first checkpoint, the run is
//! defined by the case and the source of the sample.

mod consolidation;
mod energy_balance;
pub mod estimate;
mod follow;
mod from_packing;
mod in_folders;
mod in_memory;
pub(crate) mod laboratory_error;
pub mod limits;
mod measures;
pub mod memory;
mod pace;
mod packing_simulation;
mod preparation_curve;
mod quality;
pub(crate) mod run;
mod run_state;
mod sample;
mod saved_state;
mod segment;
pub(crate) mod setup;
pub(crate) mod shared;
pub(crate) mod source;
mod status;
mod store;
mod test;
mod test_state;

pub use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT};
pub use in_memory::{PreparedSample, TestResult};
pub use laboratory_error::LaboratoryError;
pub use packing_simulation::{cell, simulation, spheres};
pub use preparation_curve::PREPARATION_COLUMNS;
pub use run_state::check_beside;
pub use setup::{CHECKPOINT_EVERY, GRAINS_PER_THREAD};
pub use shared::{Entered, Shared};
pub use source::Source;
pub use status::{Field, fields, line};
pub use store::{END, SAMPLE};

pub use crate::engine::engine_trait::Laboratory;
pub use crate::strength::late_mean;

#[cfg(test)]
mod interruption_tests;
#[cfg(test)]
mod tests;
