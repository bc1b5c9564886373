//! The path by which a record names a file.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The absolute path of a file or folder that a record is to name.
///
/// # Errors
/// [`Error::Content`] if it is not UTF-8 text, which a record in JSON needs; [`Error::File`] if the working directory no longer exists.
pub fn recordable(path: &Path) -> Result<PathBuf> {
    let absolute = std::path::absolute(path).map_err(Error::file("resolve the path", path))?;
    if absolute.to_str().is_some() {
        return Ok(absolute);
    }
    let message = "has a name with bytes that are not UTF-8 text, which the record of a run cannot hold: rename it, or give a link to it \
                   with another name";
    Err(Error::content(&absolute, message))
}
