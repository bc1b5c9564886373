//! Calibration: which properties of the grains explain laboratory curves, and how surely.
//!
//! ```text
//! priors, tests, errors --> what can these tests tell? --> draws from the posterior --> predictions, checked by simulations
//!                            (sensitivity, identifiability)
//! ```

pub mod chains;
pub mod curve;
pub mod diagnostics;
mod error;
pub mod identifiability;
pub mod likelihood;
pub mod normal;
pub mod prior;
mod random;
pub mod sensitivity;
pub mod sequential;

pub use error::{CalibrationError, Result};
