//! The tests of a laboratory, their simulations, and the surrogate that is learned from these.

pub(crate) mod differences;
pub mod emulator;
pub mod known;
pub mod same_readings;
pub mod simulation;
pub mod target;
pub mod unvaried;
