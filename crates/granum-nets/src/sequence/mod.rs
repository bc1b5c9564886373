//! Sequences in the lanes of vectors, and their rows one after the other.

pub(crate) mod sequence_group;
pub(crate) mod stepper;
