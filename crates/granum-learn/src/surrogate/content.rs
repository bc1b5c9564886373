//! The content of a surrogate in a file.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{LearnError, Result};

/// The content of a surrogate in a file: any value that can be represented in JSON.
#[derive(Clone, Debug, PartialEq)]
pub struct Content(pub(crate) serde_json::Value);

impl Content {
    /// The content from any serialisable value.
    ///
    /// # Errors
    /// If the value cannot be represented in JSON.
    pub fn new(value: &impl Serialize) -> Result<Content> {
        let failed = |error: serde_json::Error| LearnError::Content(error.to_string());
        Ok(Content(serde_json::to_value(value).map_err(failed)?))
    }

    /// Reads the value back, with bit-identical numbers.
    ///
    /// # Errors
    /// If the content is not of the requested type.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T> {
        T::deserialize(&self.0).map_err(|error| LearnError::Content(error.to_string()))
    }
}
