//! The engine of granum: the parts of a run one after another.
//!
//! ```text
//! preparation --> sample --> consolidation --> test
//! ```
//!
//! A run is a `RunState` that passes through these parts; there is a consolidation if the mean stress of the test differs
//! from that of the sample. The state is written to a checkpoint at intervals of wall time and when the user stops the run.
//! The checkpoint contains everything that determines how the run continues, so that a run can be killed at any instant
//! and, when resumed, gives results that are identical bit by bit. Before the first checkpoint, the run is defined by the
//! case and the source of the sample.

mod consolidation;
mod energy_balance;
mod follow;
mod from_packing;
pub(in crate::engine) mod measures;
mod native_engine;
mod pace;
mod pieces;
mod preparation_curve;
pub(in crate::engine) mod quality;
mod run;
mod run_state;
mod sample;
mod sample_maker;
mod saved_state;
mod segment;
mod snapshot_names;
mod task_execution;
mod test;
mod test_state;

pub use crate::task::packing_simulation::{cell, simulation, spheres};
pub(in crate::engine) use follow::{snapshot_name, stage_snapshot};
pub use native_engine::Native;
pub use pieces::RunInPieces;
pub use preparation_curve::PREPARATION_COLUMNS;
pub use run_state::check_beside;
pub(crate) use sample::last_state;
pub(in crate::engine) use sample::note;
pub(in crate::engine) use sample_maker::SampleMaker;
pub use snapshot_names::{END, SAMPLE};
pub(in crate::engine) use test_state::MOST_STAGES_NOTED;
