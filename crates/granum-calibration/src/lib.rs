//! Calibration: which properties of the grains explain laboratory curves, and how surely.
//!
//! ```text
//! priors, tests, errors --> what can these tests tell? --> draws from the posterior --> predictions, checked by simulations
//!                            (sensitivity, identifiability)
//! ```

pub mod band;
pub mod candidate_tests;
pub mod chains;
pub mod chi_square;
pub mod confirmation;
pub mod coverage;
pub mod curve;
pub mod diagnostics;
mod differences;
pub mod emulator;
mod error;
pub mod file;
pub mod fit;
pub mod identifiability;
pub mod known;
pub mod likelihood;
pub mod next_run;
pub mod next_test;
pub mod outcome;
pub mod prediction;
pub mod prior;
pub mod quantity;
mod random;
pub mod reach;
pub mod same_readings;
pub mod sample_scatter;
pub mod sensitivity;
pub mod sequential;
pub mod simulation;
pub mod target;
pub mod telling;
pub mod unvaried;

pub use error::{CalibrationError, Result};
