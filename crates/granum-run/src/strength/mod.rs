//! What a test says of its material: strength, dilatancy, critical state, stiffness and liquefaction, from what was recorded.
//!
//! Every quantity follows from the series and the stages of the test, so that it can also be found for runs of earlier versions.
//! [`of_test`] returns all of them by name; [`MEASURES`] says what each is. [`Curves`] gives the curves of a test with what they
//! are counted from. [`of_laboratory`] gives the same measures of the curves of a laboratory. Of several tests [`CriticalStates`] fits
//! a critical state line through those that are critical, and [`Envelopes`] the strength of cohesive grains.

mod as_laboratory;
mod cohesion;
pub mod critical_state_line;
mod criticality;
mod curves;
mod cyclic;
pub mod envelope;
mod flow_class;
mod late;
mod liquefaction;
mod measures;
mod monotonic;
mod names;
mod of_laboratory;
mod of_tests;
pub mod one_material;
mod regression;
mod stiffness;
pub mod symmetry;
#[cfg(test)]
mod test_records;
mod unconfined;

pub use as_laboratory::as_laboratory;
pub use cohesion::{COHESIVE, SECANT_REMARK, cohesion_of, is_cohesive};
pub use criticality::{CRITICAL_MEAN_STRESS, LateChange, late_change};
pub use curves::{CARRIES_STRESS, Curves};
pub use flow_class::{FREE_FLOWING, flow_class};
pub use late::{LATE, late_mean};
pub(crate) use liquefaction::ended_liquefied;
pub use liquefaction::{LIQUEFIED_DOUBLE_AMPLITUDE, LIQUEFIED_RATIO};
pub use measures::{of_run, of_test};
pub use names::{MEASURES, Meaning, meaning};
pub use of_laboratory::of_laboratory;
pub use of_tests::{CriticalStates, Envelopes, Judged, Tested, left_out, taking_part};
