//! What can go wrong with a scheduler.

use granum_run::queue::QueueError;
use thiserror::Error;

/// Why a scheduler could not do what it was asked for.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SchedulerError {
    /// There is no such scheduler.
    #[error("there is no scheduler {name:?}; there are: {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
    /// The runs contradict each other, or a file cannot be read or written.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// A program of the scheduler is not there or refuses.
    #[error("{command}: {reason}")]
    Command {
        /// The program.
        command: String,
        /// What it said.
        reason: String,
    },
    /// An option that it cannot follow.
    #[error("{0}")]
    Option(String),
}
