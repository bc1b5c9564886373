//! Gaussian processes for hundreds of rows: a prediction with its uncertainty from rows with noise, without a network.
//!
//! ```
//! use granum_nets::gaussian_process::{FitOptions, GaussianProcess, Rows};
//!
//! // A wave with noise that alternates.
//! let x: Vec<f64> = (0..40).map(|k| k as f64 / 10.0 - 2.0).collect();
//! let y: Vec<f64> = x.iter().enumerate().map(|(k, x)| (2.0 * x).sin() + if k % 2 == 0 { 0.1 } else { -0.1 }).collect();
//! let process = GaussianProcess::fit(Rows::new(x, 1)?.into(), &y, &FitOptions::default())?;
//!
//! let inside = process.predict(&[0.25]);
//! assert!((inside.mean - 0.5f64.sin()).abs() < 0.1, "{inside:?}");
//! assert!((inside.noise.sqrt() - 0.1).abs() < 0.03, "{inside:?}");
//! // Far from all rows it knows less.
//! assert!(process.predict(&[4.0]).variance > 10.0 * inside.variance);
//! # Ok::<(), granum_nets::gaussian_process::GaussianProcessError>(())
//! ```

mod covariance;
mod error;
mod evidence;
mod left_out_blocks;
mod observations;
mod parts;
mod prior;
mod process;
mod rows;
#[cfg(test)]
mod tests;

pub use error::GaussianProcessError;
pub use left_out_blocks::LeftOutBlocks;
pub use observations::{Observations, PosteriorCovariance};
pub use parts::ProcessParts;
pub use prior::Prior;
pub use process::{FitOptions, FurtherRow, GaussianProcess, LeftOut, ProcessPrediction};
pub use rows::Rows;
