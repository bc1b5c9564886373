//! Where a sample comes from.

use std::path::PathBuf;

use granum_io::recordable;
use granum_io::run::{self, RunSource};

use super::laboratory_error::LaboratoryError;

/// The source of a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// It is prepared as the case specifies.
    Case,
    /// It is read from the folder that `granum prepare` wrote.
    Folder(PathBuf),
    /// It is made from a packing file, which has no contact history. A loose packing is compacted as the case specifies; one
    /// that already carries its load is only brought to rest at the mean stress of the case.
    Packing(PathBuf),
}

impl Source {
    /// The source for the record of a run, with absolute paths, so that the run can be resumed from any working directory.
    /// Paths that a record cannot hold are refused.
    pub(crate) fn record(&self) -> Result<RunSource, LaboratoryError> {
        Ok(match self {
            Source::Case => RunSource::Case,
            Source::Folder(path) => RunSource::Sample(recordable(path)?),
            Source::Packing(path) => {
                RunSource::Packing { file: recordable(path)?, sha256: run::file_digest(path)? }
            }
        })
    }

    /// The source that a record names. A packing file that is missing or was changed is refused, since it would give another
    /// sample.
    pub(crate) fn recorded(source: &RunSource) -> Result<Source, LaboratoryError> {
        match source {
            RunSource::Case => Ok(Source::Case),
            RunSource::Sample(path) => Ok(Source::Folder(path.clone())),
            RunSource::Packing { file, sha256 } => {
                if run::file_digest(file)? != *sha256 {
                    let message =
                        "was changed since the run began, and there is no checkpoint of it yet; run it again";
                    return Err(granum_io::Error::content(file, message).into());
                }
                Ok(Source::Packing(file.clone()))
            }
        }
    }
}
