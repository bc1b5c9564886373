//! A run that is planned.

use std::path::PathBuf;

use granum_io::Case;
use granum_io::run::RunKind;

use crate::task::source::Source;

/// A run that is planned: what it does, with which case and sample, and in which folder.
#[derive(Clone, Debug, PartialEq)]
pub struct QueuedRun {
    /// Its name, which no other run of its queue has.
    pub name: String,
    /// What it does.
    pub kind: RunKind,
    /// The case, which determines the result.
    pub case: Case,
    /// Where the sample comes from.
    pub source: Source,
    /// The folder of the run.
    pub folder: PathBuf,
    /// The keys by which it differs from the other runs, with their values as a user writes them; empty if that is not known.
    pub values: Vec<(String, String)>,
    /// Name of the run that must be finished before, that of its sample.
    pub after: Option<String>,
}

impl QueuedRun {
    /// A test.
    pub fn test(
        name: impl Into<String>,
        case: Case,
        source: Source,
        folder: impl Into<PathBuf>,
    ) -> QueuedRun {
        QueuedRun {
            name: name.into(),
            kind: RunKind::Test,
            case,
            source,
            folder: folder.into(),
            values: Vec::new(),
            after: None,
        }
    }

    /// The preparation of a sample.
    pub fn sample(
        name: impl Into<String>,
        case: Case,
        source: Source,
        folder: impl Into<PathBuf>,
    ) -> QueuedRun {
        QueuedRun { kind: RunKind::Sample, ..QueuedRun::test(name, case, source, folder) }
    }
}
