//! Data sets from runs, and surrogates that are fitted to them and evaluated on unseen runs.
//!
//! ```text
//! runs --> Dataset --> SurrogateMethod::fit --> Surrogate --> predictions with intervals
//!            (split)                              (scored, saved)
//! ```
//!
//! A [`Dataset`] consists of named columns over the states of runs, for tests along arbitrary paths. A [`SurrogateMethod`]
//! fits a [`Surrogate`] to it. Networks, ridge regression and user-defined methods are scored in the same way by
//! [`compare`], are saved in a common format, and are found by name in [`SurrogateMethods`].
//!
//! ```
//! use granum_core::observer::NoObserver;
//! use granum_core::{Column, Table};
//! use granum_learn::{Dataset, FitSpec, RunStates, Split, SurrogateMethods, compare};
//!
//! // Three runs with the columns x and y = x^2, with a small difference between the runs.
//! let run = |k: u32| {
//!     let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 39.0).collect();
//!     let y = x.iter().map(|x| x * x + 0.01 * f64::from(k) * x).collect();
//!     RunStates::new(&format!("run-{k}"), Table::new(vec![Column::new("x", "m", x), Column::new("y", "m2", y)])?)
//! };
//! let dataset = Dataset::new((1..=3).map(run).collect::<granum_learn::Result<_>>()?)?;
//! let parts = dataset.split(&Split::default().unseen(["run-3"]))?;
//!
//! let methods = SurrogateMethods::standard();
//! let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
//! let compared = [methods.by_name("ridge")?, methods.by_name("feed-forward")?];
//! for scored in compare(&parts, &spec, &compared, 0.9, &mut NoObserver)? {
//!     assert!(scored.unseen.relative_rmse < 0.05, "{} {:?}", scored.method, scored.unseen);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// The synthetic records of the tests are shared with the tests of another crate and name this one as that crate does.
#[cfg(test)]
extern crate self as granum_learn;

pub mod active_learning;
mod comparison;
pub mod curve;
pub mod dataset;
mod error;
pub mod examine;
pub mod family;
pub mod inference;
pub mod input_use;
pub mod learning_curve;
mod methods;
pub mod onnx;
mod onnx_export;
mod pooled_error;
pub mod regression;
pub mod runs;
pub mod scatter;
pub mod score;
pub mod student_t;
pub mod study;
pub mod surrogate;
#[cfg(test)]
mod synthetic;
pub mod worth;

pub use comparison::{SurrogateScores, compare, score_surrogate, score_where};
pub use dataset::{Dataset, NamedRecord, RunStates, Split, SplitParts, Variable};
pub use error::{LearnError, Result};
pub use methods::networks;
pub use pooled_error::PooledError;
pub use score::Score;
pub use surrogate::{FitSpec, Prediction, Surrogate, SurrogateMethod, SurrogateMethods};
