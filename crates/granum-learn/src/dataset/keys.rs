//! The columns of the key of a state.

/// The number of the stage of the test, from 1.
pub(crate) const STAGE: &str = "stage";
/// The number of the state in its stage, from 0.
pub(crate) const STATE: &str = "state";
