//! How the runs of a queue end.

use granum_io::RunRecord;
use thiserror::Error;

use crate::task::laboratory_error::LaboratoryError;

/// How a run of a queue ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum Outcome {
    /// It is finished.
    Finished {
        /// Its record.
        record: Box<RunRecord>,
        /// True if it had been finished before.
        reused: bool,
    },
    /// It was stopped in good order and can be continued.
    Interrupted(Box<RunRecord>),
    /// It was not begun, since the queue was stopped before.
    NotBegun,
    /// It is a sample that no unfinished run needs.
    NotNeeded,
    /// It failed.
    Failed(RunError),
    /// The run that it waited for failed.
    WithoutSample {
        /// Name of that run.
        sample: String,
    },
}

impl Outcome {
    /// The record of the run, if it has one.
    pub fn record(&self) -> Option<&RunRecord> {
        match self {
            Outcome::Finished { record, .. } | Outcome::Interrupted(record) => Some(record),
            _ => None,
        }
    }

    /// True if the run need not be executed any more.
    pub fn is_finished(&self) -> bool {
        matches!(self, Outcome::Finished { .. } | Outcome::NotNeeded)
    }

    /// True if the run was stopped by the user, or not begun for that reason.
    pub fn is_stopped(&self) -> bool {
        matches!(self, Outcome::Interrupted(_) | Outcome::NotBegun)
    }

    /// One word for it: `finished`, `interrupted`, `not begun`, `not needed` or `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            Outcome::Finished { .. } => "finished",
            Outcome::Interrupted(_) => "interrupted",
            Outcome::NotBegun => "not begun",
            Outcome::NotNeeded => "not needed",
            Outcome::Failed(_) | Outcome::WithoutSample { .. } => "failed",
        }
    }

    /// Why the run failed, if it did.
    pub fn failure(&self) -> Option<String> {
        match self {
            Outcome::Failed(error) => Some(error.to_string()),
            Outcome::WithoutSample { sample } => Some(format!("its sample {sample} failed")),
            _ => None,
        }
    }
}

/// Why a run of a queue failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The run could not be executed or failed.
    #[error(transparent)]
    Laboratory(#[from] LaboratoryError),
    /// Its folder cannot be used.
    #[error(transparent)]
    File(#[from] granum_io::Error),
    /// The process of the run ended before the run, or tells why it could not execute it.
    #[error("{0}")]
    Process(String),
    /// The process of the run tells that the run failed for a reason that lies in its case.
    #[error("{0}")]
    Lasting(String),
    /// It was stopped, by the user, before there was anything to continue from.
    #[error("it was stopped before it had begun")]
    NotBegun,
    /// The program has a mistake.
    #[error("the run ended by a mistake of the program: {0}")]
    Panic(String),
}

impl RunError {
    /// True if the run fails for a reason that lies in its case, so that it would fail in the same way again; false for what may have
    /// gone when it is tried again: a full disk, too little memory, a process that was killed.
    pub fn is_lasting(&self) -> bool {
        match self {
            RunError::Laboratory(error) => !matches!(
                error,
                LaboratoryError::File(_)
                    | LaboratoryError::Memory { .. }
                    | LaboratoryError::Checkpoint { .. }
                    | LaboratoryError::Damaged { .. }
                    | LaboratoryError::Unusable { .. }
            ),
            RunError::File(_) | RunError::Process(_) | RunError::NotBegun | RunError::Panic(_) => false,
            RunError::Lasting(_) => true,
        }
    }
}
