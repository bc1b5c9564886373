//! The evaluation of the laws of a set for a contact, or for eight: the part that all laws have in common, and what a contact remembers.

pub mod constants;
pub mod frame;
pub mod interaction;
pub mod memory;
pub mod observed;
pub mod set;
pub(super) mod steps;
