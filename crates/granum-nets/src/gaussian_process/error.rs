//! The error of Gaussian processes.

use thiserror::Error;

/// A Gaussian process cannot be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GaussianProcessError {
    /// The rows are not usable.
    #[error("{0}")]
    Rows(String),
    /// The parameters are not those of such a process.
    #[error("{found} parameters are not those of a Gaussian process of {inputs} inputs, which has {needed}")]
    Parameters {
        /// Number of parameters given.
        found: usize,
        /// Number of inputs.
        inputs: usize,
        /// Number of parameters that it has.
        needed: usize,
    },
    /// The covariance of the rows cannot be factorised.
    #[error("the covariance of the rows is not positive definite; are there infinite or huge values?")]
    NotPositive,
}
