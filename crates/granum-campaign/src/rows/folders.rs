//! The folders of runs: what is kept of them, and how they go.

use std::fs;
use std::path::Path;

use granum_io::case::Vocabulary;
use granum_io::{Error, Result, Run, RunFolder};
use granum_run::digest;
use granum_run::record::read_record;

use super::stored_run::StoredRun;

/// Folder into which the folders of runs are moved before they are removed.
const REMOVED: &str = ".granum-removed";

/// Reads what is kept of a finished run from its folder, whose files are compared with their SHA-256 and whose case can name these
/// laws, paths and sensors.
///
/// # Errors
/// If a file of the run is missing, changed or damaged.
pub fn read_run(folder: &Path, vocabulary: &Vocabulary) -> Result<StoredRun> {
    let run = Run::at(folder)?.with_vocabulary(vocabulary);
    let mut record = run.record()?;
    // The rows move with the campaign, as the folder would.
    record.source = record.source.relative_to(folder)?;
    Ok(StoredRun { record, digest: digest::of_run(&run)?, measured: read_record(&run)? })
}

/// Removes the folder of a run or sample of a campaign: wherever the process is killed, the folder is whole or gone.
///
/// # Errors
/// If a process is at work in it, it holds a file that granum did not write, or cannot be removed.
pub fn remove_folder(campaign: &Path, folder: &Path) -> Result<()> {
    RunFolder::open(folder)?.remove(&campaign.join(REMOVED))
}

/// Removes what a killed process left of folders that it was removing. Only for the holder of the campaign's lock.
///
/// # Errors
/// [`Error::File`] if it cannot be removed.
pub fn forget_leftovers(campaign: &Path) -> Result<()> {
    let path = campaign.join(REMOVED);
    if fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_dir()) {
        fs::remove_dir_all(&path).map_err(Error::file("remove", &path))?;
    }
    Ok(())
}
