//! What can go wrong in a study.

use thiserror::Error;

/// An error of this crate.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LearnError {
    /// A record cannot be used.
    #[error("record `{run}`: {reason}")]
    Record {
        /// Name of the run.
        run: String,
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// A data set cannot be made or used.
    #[error("data set: {0}")]
    Dataset(String),
    /// A table cannot be made, or lacks a column.
    #[error(transparent)]
    Table(#[from] granum_core::TableError),
    /// A sub-model has too little to learn from.
    #[error(
        "{mapping} sub-model {sub_model} (deviator strain {low} to {high}) has {found} training states, needs {needed}; \
         record more states or widen its range"
    )]
    TooFewStates {
        /// Name of the mapping.
        mapping: String,
        /// Number of the sub-model, from 1.
        sub_model: usize,
        /// Start of its range.
        low: f64,
        /// End of its range.
        high: f64,
        /// States there are.
        found: usize,
        /// States there should be.
        needed: usize,
    },
    /// A row of a table cannot be answered.
    #[error("{0}")]
    Rows(String),
    /// No mapping or network of that name.
    #[error("there is no {kind} `{name}`; there are: {known}")]
    Unknown {
        /// What was looked for.
        kind: &'static str,
        /// Its name.
        name: String,
        /// What there is.
        known: String,
    },
    /// The study was asked to stop before it was complete.
    #[error("stopped on request after {done} of {total} networks")]
    Stopped {
        /// Networks trained.
        done: usize,
        /// Networks wanted.
        total: usize,
    },
    /// A network cannot be made or trained.
    #[error("{network}: {reason}")]
    Network {
        /// Which one.
        network: String,
        /// What is wrong.
        reason: String,
    },
    /// A surrogate cannot be fitted, or cannot answer.
    #[error("{method}: {reason}")]
    Surrogate {
        /// Name of its method.
        method: String,
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// The file of a surrogate cannot be used.
    #[error("{file}: {reason}")]
    SurrogateFile {
        /// The file.
        file: String,
        /// What is wrong, and what would be right.
        reason: String,
    },
    /// What a surrogate keeps of itself is not what its method expects.
    #[error("the content is not that of such a surrogate: {0}")]
    Content(String),
    /// A folder holds something that would be replaced.
    #[error("{} already holds {holds}; {advice}", folder.display())]
    Taken {
        /// The folder.
        folder: std::path::PathBuf,
        /// What is in it.
        holds: String,
        /// The command line that goes on from it, and what else can be done.
        advice: String,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Files(#[from] granum_io::Error),
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, LearnError>;
