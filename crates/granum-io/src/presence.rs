//! Whether a file that tells what a folder is stands there.

use std::path::Path;

use crate::error::{Error, Result};

/// True if there is a regular file, or a link to one; false if there is nothing. Anything else in its place must not be taken for
/// nothing: the folder would be taken for one of another kind.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// assert!(!granum_io::is_there(&folder.path().join("runs.json"))?);
/// assert!(granum_io::is_there(folder.path()).is_err(), "a folder is no file");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Error::Content`] if a folder, a pipe, a device or a link that leads nowhere is in its place.
pub fn is_there(path: &Path) -> Result<bool> {
    if path.is_file() {
        return Ok(true);
    }
    if path.symlink_metadata().is_err() {
        return Ok(false);
    }
    let message = "is not a regular file, so that it is not known what the folder is; put the file back";
    Err(Error::content(path, message))
}
