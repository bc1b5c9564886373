//! Why a queue is refused.

use std::path::PathBuf;

use thiserror::Error;

use crate::task::laboratory_error::LaboratoryError;
use granum_io::shell::ShowPath;

/// Why a queue is refused before any of its runs begins.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum QueueError {
    /// Two runs have one name.
    #[error("two runs have the name {0}")]
    SameName(String),
    /// Two runs have one folder.
    #[error("two runs have the folder {}", .0.shown())]
    SameFolder(PathBuf),
    /// A run waits for one that is not in the queue.
    #[error("the run {run} waits for {after}, which is not in the queue")]
    NoSuchRun {
        /// The run that waits.
        run: String,
        /// The name for which it waits.
        after: String,
    },
    /// Runs wait for each other.
    #[error("the run {0} waits for itself, directly or through other runs")]
    Circle(String),
    /// A run cannot be executed.
    #[error("{run}: {source}")]
    Run {
        /// Name of the run.
        run: String,
        /// Why not.
        source: Box<LaboratoryError>,
    },
    /// The folder of a run holds another run.
    #[error(
        "{}: its run has another case or version (granum {version}) than the one that is planned here",
        folder.shown()
    )]
    OtherRun {
        /// The folder.
        folder: PathBuf,
        /// Version of granum that executed the other run.
        version: String,
    },
    /// A file or folder cannot be used.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// Too many combinations of values.
    #[error("the values have {count} combinations; at most {most} runs are possible at once")]
    TooMany {
        /// Their number.
        count: usize,
        /// The largest number.
        most: usize,
    },
}
