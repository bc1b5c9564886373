//! The format number of a JSON file, and the messages for files that cannot be read.

use std::path::Path;

use serde::Deserialize;

use crate::error::{Error, Result};

/// Rejects JSON whose `format` is newer than `newest`; returns the format.
pub(crate) fn check_format(path: &Path, text: &str, newest: u32) -> Result<u32> {
    #[derive(Deserialize)]
    struct Head {
        format: u32,
    }
    let head: Head = serde_json::from_str(text).map_err(|error| damaged(path, &error))?;
    if head.format > newest {
        let message = format!(
            "was written by a newer granum (format {}; this one reads up to {newest}); use that version",
            head.format
        );
        return Err(Error::content(path, message));
    }
    Ok(head.format)
}

/// The error for JSON that cannot be read: truncated or damaged.
pub(crate) fn damaged(path: &Path, error: &serde_json::Error) -> Error {
    let why = if error.is_eof() { "is truncated" } else { "is damaged" };
    Error::content(path, format!("{why} ({error})"))
}
