//! Errors about shapes.

use std::fmt;

/// Reasons why there is no such shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ShapeError {
    /// The key in the section `[grains.shape]` that is wrong.
    pub key: &'static str,
    /// What is wrong and what would be right, as a sentence that begins with the key.
    pub message: String,
}

impl ShapeError {
    /// An error about a key; the message continues it.
    pub fn new(key: &'static str, message: impl fmt::Display) -> ShapeError {
        ShapeError { key, message: format!("{key} {message}") }
    }
}
