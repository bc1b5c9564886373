//! Calibration: which properties of the grains explain laboratory curves, and how surely.
//!
//! ```text
//! priors, tests, errors --> what can these tests tell? --> draws from the posterior --> predictions, checked by simulations
//!                            (sensitivity, identifiability)
//! ```

pub mod compared;
pub mod draws;
mod error;
pub mod file;
pub mod inference;
pub mod posterior;
pub mod questions;
pub mod simulations;

pub use error::{CalibrationError, Result};
