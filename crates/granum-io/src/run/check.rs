//! The check of the files of a run: each must be the one of which its record holds the SHA-256.

use std::path::{Path, PathBuf};

use super::file_digest::file_digest;
use super::record::RunRecord;
use crate::error::{Error, Result};
use crate::shell::ShowPath;

/// A file of a run that is not the one that the run wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileFault {
    /// Its name in the folder, e.g. `snapshots/end.json`.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// What is wrong.
    pub what: &'static str,
}

const MISSING: &str = "is missing, although run.json lists it";
const CHANGED: &str = "was changed or exchanged since the run wrote it: its SHA-256 is not that in run.json";
const FOREIGN: &str = "is not a file of this run: run.json does not list it";

impl FileFault {
    /// The error of a reader that needs the file.
    pub fn error(&self) -> Error {
        let message = format!("{}; put the file back, or run the case again", self.what);
        Error::content(&self.path, message)
    }
}

impl std::fmt::Display for FileFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.path.shown(), self.what)
    }
}

/// Compares a file with the record; `None` if it is the file that the run wrote, or was never written, or cannot be checked,
/// since the record is of an earlier version and has no SHA-256 of it.
///
/// # Errors
/// [`Error::File`] if the file cannot be read.
pub(super) fn fault(folder: &Path, record: &RunRecord, name: &str) -> Result<Option<FileFault>> {
    let path = folder.join(name);
    let fault = |what| Some(FileFault { name: name.to_string(), path: path.clone(), what });
    let (known, before) = (record.content.get(name), record.replaced.get(name));
    if !path.is_file() {
        // A run that was killed while it wrote the file for the first time.
        let is_due = known.is_some() && before.is_none_or(|before| !before.is_empty());
        return Ok(if is_due { fault(MISSING) } else { None });
    }
    let Some(known) = known else { return Ok(if record.lists_all() { fault(FOREIGN) } else { None }) };
    let found = file_digest(&path)?;
    Ok(if found == *known || before == Some(&found) { None } else { fault(CHANGED) })
}
