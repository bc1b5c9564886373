//! What a test says of its material: strength, dilatancy, critical state, stiffness and liquefaction, from what was recorded.
//!
//! Every quantity follows from the series and the stages of the test, so that it can also be found for runs of earlier versions.
//! [`of_test`] returns all of them by name; [`MEASURES`] says what each is. [`Curves`] gives the curves of a test with what they
//! are counted from, and [`critical_state_line`] fits a line through the late states of several tests.

mod as_laboratory;
pub mod critical_state_line;
mod curves;
mod cyclic;
mod flow_class;
mod late;
mod liquefaction;
mod measures;
mod monotonic;
mod names;
pub mod one_material;
mod stiffness;
pub mod symmetry;
mod unconfined;

pub use as_laboratory::as_laboratory;
pub use curves::{CARRIES_STRESS, Curves};
pub use flow_class::{FREE_FLOWING, flow_class};
pub use late::{LATE, late_mean};
pub(crate) use liquefaction::ended_liquefied;
pub use liquefaction::{LIQUEFIED_DOUBLE_AMPLITUDE, LIQUEFIED_RATIO};
pub use measures::{of_run, of_test};
pub use names::{MEASURES, Meaning, meaning};
