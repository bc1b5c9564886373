//! Distributions, with the same bits on every machine.

pub mod normal;
pub(crate) mod student_t;
