//! The errors of this crate.

use thiserror::Error;

/// An error of a calibration.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// A prior has no sense.
    #[error("prior of {name}: {reason}")]
    Prior {
        /// The property.
        name: String,
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// Curves, errors or parameters do not fit each other.
    #[error("{0}")]
    Input(String),
    /// No value of the parameters within their priors explains the tests.
    #[error("nothing within the priors explains the tests, so that there is no posterior: {}", .0.join("; "))]
    NothingFits(Vec<String>),
    /// The chains do not agree: nothing that they drew may be used.
    #[error(
        "the chains do not agree after {draws} draws each: {parameter} has R-hat {r_hat:.3} (at most {most_r_hat} is needed) and an effective \
         sample of {effective:.0} draws (at least {least_effective:.0}); allow more draws, or free less: the data may not fix this parameter"
    )]
    NotConverged {
        /// The parameter that is worst.
        parameter: String,
        /// Draws of each chain.
        draws: usize,
        /// Its R-hat.
        r_hat: f64,
        /// The largest R-hat that is accepted.
        most_r_hat: f64,
        /// The smaller of its effective sample sizes, of the bulk and of the tails.
        effective: f64,
        /// The smallest effective sample size that is accepted.
        least_effective: f64,
    },
    /// A file cannot be read or written, or has mistakes.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// A surrogate cannot be fitted to the simulations.
    #[error("the surrogate of the simulations: {0}")]
    Surrogate(#[from] granum_learn::LearnError),
    /// An observer requested the end.
    #[error("stopped on request")]
    Stopped,
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, CalibrationError>;
