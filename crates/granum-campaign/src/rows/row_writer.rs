//! Takes runs into a file of rows.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use granum_io::{Error, Result, inner_folder};

use super::row_files::{BEGINNING, ENDING, ROWS, StoredHead};
use super::stored_run::StoredRun;

/// Appends runs to a file of its own in the folder of a campaign, which it creates with the first run.
#[derive(Debug)]
pub struct RowWriter {
    campaign: PathBuf,
    file: Option<(PathBuf, File)>,
}

impl RowWriter {
    /// A writer for the campaign in a folder; nothing is written yet.
    pub fn new(campaign: &Path) -> RowWriter {
        RowWriter { campaign: campaign.to_path_buf(), file: None }
    }

    /// Appends runs with their names. When this returns `Ok` they are on the disk.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be written. What was written of it is passed over by readers, and the next runs go into another
    /// file.
    pub fn append(&mut self, runs: &[(String, StoredRun)]) -> Result<()> {
        let mut bytes = Vec::new();
        for (name, run) in runs {
            let rows = run.encode();
            let head = StoredHead::new(name, &run.record, &rows);
            // Texts and numbers can always be written.
            let head = serde_json::to_vec(&head).unwrap_or_default();
            bytes.extend((head.len() as u64).to_le_bytes());
            bytes.extend((rows.len() as u64).to_le_bytes());
            bytes.extend(head);
            bytes.extend(rows);
        }
        if bytes.is_empty() {
            return Ok(());
        }
        let (path, mut file) = match self.file.take() {
            Some(known) => known,
            None => self.create()?,
        };
        file.write_all(&bytes).and_then(|()| file.sync_data()).map_err(Error::file("write", &path))?;
        self.file = Some((path, file));
        Ok(())
    }

    /// A file with the next free number. A process that creates one at the same time gets another number.
    fn create(&self) -> Result<(PathBuf, File)> {
        let folder = inner_folder(&self.campaign, ROWS)?;
        // After all that are there, since of several rows of a run those of the last file count.
        let entries = fs::read_dir(&folder).map_err(Error::file("read", &folder))?.flatten();
        let number = |entry: fs::DirEntry| entry.path().file_stem()?.to_str()?.parse::<u32>().ok();
        let last = entries.filter_map(number).max().unwrap_or(0);
        for number in u64::from(last) + 1.. {
            let path = folder.join(format!("{number:04}.{ENDING}"));
            match OpenOptions::new().append(true).create_new(true).open(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(Error::file("write", &path)(error)),
                Ok(mut file) => {
                    let mut begin = || -> io::Result<()> {
                        file.write_all(BEGINNING)?;
                        sync(&folder)
                    };
                    begin().map_err(Error::file("write", &path))?;
                    return Ok((path, file));
                }
            }
        }
        Err(Error::content(&folder, "has no free number for another file"))
    }
}

/// Makes the name of a new file survive a power failure.
#[cfg(unix)]
fn sync(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync(_: &Path) -> io::Result<()> {
    Ok(())
}
