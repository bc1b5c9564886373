//! The errors of this crate.

use granum_io::shell::ShowPath;
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
        "{mapping} sub-model {sub_model} ({} {} to {}) has {found} training states, needs {needed}; \
         record more states or widen its range", coordinate.replace('_', " "), brief(*.low), brief(*.high)
    )]
    TooFewStates {
        /// Name of the mapping.
        mapping: String,
        /// Number of the sub-model, from 1.
        sub_model: usize,
        /// Name of the coordinate.
        coordinate: String,
        /// Start of its range.
        low: f64,
        /// End of its range.
        high: f64,
        /// Number of training states.
        found: usize,
        /// Required number of training states.
        needed: usize,
    },
    /// A row of a table cannot be predicted.
    #[error("{0}")]
    Rows(String),
    /// There is no mapping, surrogate or method of the given name; the nearest one is suggested, or all are listed.
    #[error("there is no {kind} `{name}`; {}", granum_core::names::suggestion(name, known.split(", ")))]
    Unknown {
        /// The kind of object.
        kind: &'static str,
        /// The given name.
        name: String,
        /// The existing names.
        known: String,
    },
    /// The study was stopped by its observer before it was complete.
    #[error("stopped on request after {done} of {total} surrogates")]
    Stopped {
        /// Number of fitted surrogates, or of trained networks of one.
        done: usize,
        /// Number of all of them.
        total: usize,
    },
    /// A network cannot be created or trained.
    #[error("{network}: {reason}")]
    Network {
        /// Name of the network.
        network: String,
        /// What is wrong.
        reason: String,
    },
    /// A surrogate cannot be fitted, or cannot predict.
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
    /// The stored content of a surrogate is not what its method expects.
    #[error("the content is not that of a surrogate of this method: {0}")]
    Content(String),
    /// The contents of a folder would be replaced.
    #[error("{} already contains {holds}; {advice}", folder.shown())]
    Taken {
        /// The folder.
        folder: std::path::PathBuf,
        /// Description of the contents.
        holds: String,
        /// The command line that continues from the contents, and alternatives.
        advice: String,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Files(#[from] granum_io::Error),
}

/// A strain with the digits that a reader of a message needs.
fn brief(strain: f64) -> f64 {
    (strain * 1e6).round() / 1e6
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, LearnError>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strains_in_messages_are_brief() {
        let error = LearnError::TooFewStates {
            mapping: "F2".into(),
            sub_model: 1,
            coordinate: "deviator_strain".into(),
            low: 0.0,
            high: 0.01 / 3.0,
            found: 2,
            needed: 3,
        };
        assert!(error.to_string().contains("(deviator strain 0 to 0.003333)"), "{error}");
    }
}
