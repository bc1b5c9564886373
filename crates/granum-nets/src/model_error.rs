//! Why a model cannot be made, used, saved or loaded.

use crate::data::DataError;
use crate::network::NetworkError;
use crate::trainer::TrainingError;

/// Why a model cannot be fitted, used, saved or loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The shape of the network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The rows.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The training.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// Columns of a recipe do not fit the data.
    #[error("{0}")]
    Columns(String),
    /// A row to predict has the wrong length.
    #[error("a row for this model has {expected} inputs ({names}), not {given}")]
    RowLength {
        /// Inputs of the model.
        expected: usize,
        /// Their names.
        names: String,
        /// Length of the row.
        given: usize,
    },
    /// A value to predict from is not finite.
    #[error("row {row}, input {name}: {value} is not a finite number")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// Name of the input.
        name: String,
        /// The value.
        value: f64,
    },
    /// MacroState or writing failed.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no model, or damaged, or newer than this program.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: String,
        /// What is wrong and what would be right.
        problem: String,
    },
}
