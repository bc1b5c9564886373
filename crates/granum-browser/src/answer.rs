//! Why a call failed, as a page shows it.

use granum_io::Error as FileError;
use granum_learn::LearnError;
use granum_run::LaboratoryError;
use serde_json::{Value, json};

/// Why a call failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CallError {
    /// The message is no object with a known call and its arguments.
    #[error("{0}")]
    Message(String),
    /// Something is wrong with the text of a case.
    #[error(transparent)]
    Case(#[from] FileError),
    /// A run cannot be made, or failed.
    #[error(transparent)]
    Laboratory(#[from] LaboratoryError),
    /// A surrogate cannot answer.
    #[error(transparent)]
    Surrogate(#[from] LearnError),
}

impl CallError {
    /// The answer: a message, and where it is known its places in the text of the case.
    pub(crate) fn answer(&self) -> Value {
        let inputs = match self {
            CallError::Case(error) | CallError::Laboratory(LaboratoryError::File(error)) => places(error),
            _ => Vec::new(),
        };
        json!({ "error": { "message": self.to_string(), "places": inputs } })
    }
}

/// Each mistake in the text of a case with its line and column from 1, and what would be right.
fn places(error: &FileError) -> Vec<Value> {
    let mistakes = match error {
        FileError::Input(one) => std::slice::from_ref(one.as_ref()),
        FileError::Inputs(several) => several.as_slice(),
        _ => &[],
    };
    mistakes
        .iter()
        .map(|mistake| {
            json!({
                "line": mistake.line, "column": mistake.column, "message": mistake.message, "help": mistake.help,
                "span": [mistake.span.start, mistake.span.end],
            })
        })
        .collect()
}
