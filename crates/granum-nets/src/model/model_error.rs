//! The errors of models.

use crate::feed_forward::network::NetworkError;
use crate::table::data_error::DataError;
use crate::training_error::TrainingError;

/// Why a model cannot be fitted, used, saved or loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The shape of the network is invalid.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The rows are invalid.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The training failed.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// The columns of a definition do not match the data.
    #[error("{0}")]
    Columns(String),
    /// A row to predict has the wrong length.
    #[error("a row for this model has {expected} inputs ({names}), not {given}")]
    RowLength {
        /// Number of inputs of the model.
        expected: usize,
        /// Names of the inputs.
        names: String,
        /// Length of the row.
        given: usize,
    },
    /// An input value of a prediction is not finite.
    #[error("row {row}, input {name}: {value} is not a finite number")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// Name of the input.
        name: String,
        /// The value.
        value: f64,
    },
    /// Reading or writing failed.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The file is not a model, is damaged, or is newer than this program.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: String,
        /// What is wrong, and what would be valid.
        problem: String,
    },
}
