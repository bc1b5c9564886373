//! The files of rows of a campaign, for reading.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use granum_core::digest::sha256;
use granum_io::{Error, Result, RunRecord};
use serde::{Deserialize, Serialize};

use super::stored_run::StoredRun;
use crate::journal::JournalEvent;

/// Folder of the files.
pub(super) const ROWS: &str = "rows";
/// Ending of their names.
pub(super) const ENDING: &str = "rows";
/// First line of a file.
pub(super) const BEGINNING: &[u8] = b"granum rows 1\n";
/// A longer head is damaged.
const LONGEST_HEAD: u64 = 1 << 20;

/// What is known of a run in a file of rows before its rows are read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredHead {
    /// Name of the run.
    pub run: String,
    /// Digest of its case.
    pub case_digest: String,
    /// Version of granum that executed it.
    pub granum_version: String,
    /// Its engine.
    pub engine: String,
    /// How it ended, with the checks that it did not pass.
    #[serde(flatten)]
    pub event: JournalEvent,
    /// SHA-256 of its rows.
    pub sha256: String,
}

impl StoredHead {
    /// The head of the rows of a run.
    pub(super) fn new(run: &str, record: &RunRecord, rows: &[u8]) -> StoredHead {
        StoredHead {
            run: run.to_string(),
            case_digest: record.case_digest.clone(),
            granum_version: record.granum_version.clone(),
            engine: record.engine.clone(),
            event: JournalEvent::finished(record),
            sha256: sha256(rows),
        }
    }
}

/// Where the rows of a run are.
#[derive(Clone, Debug)]
struct Place {
    head: StoredHead,
    file: usize,
    start: u64,
    length: u64,
}

/// The runs that have been taken in, by name. Their rows are read when they are asked for.
#[derive(Clone, Debug, Default)]
pub struct RowFiles {
    files: Vec<PathBuf>,
    places: BTreeMap<String, Place>,
}

impl RowFiles {
    /// Reads the heads of all runs in the files of a campaign's folder; of several of one name the last one counts.
    ///
    /// # Errors
    /// [`Error::File`] if a file cannot be read.
    pub fn read(campaign: &Path) -> Result<RowFiles> {
        let folder = campaign.join(ROWS);
        let mut found = RowFiles::default();
        if !folder.is_dir() {
            return Ok(found);
        }
        for entry in std::fs::read_dir(&folder).map_err(Error::file("read", &folder))? {
            let path = entry.map_err(Error::file("read", &folder))?.path();
            if path.extension().is_some_and(|ending| ending == ENDING) && path.is_file() {
                found.files.push(path);
            }
        }
        // 10000.rows comes after 9999.rows.
        found.files.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
        for number in 0..found.files.len() {
            let places = heads(&found.files[number]).map_err(Error::file("read", &found.files[number]))?;
            for (head, start, length) in places {
                found.places.insert(head.run.clone(), Place { head, file: number, start, length });
            }
        }
        Ok(found)
    }

    /// What is known of a run, if it has been taken in.
    pub fn head(&self, run: &str) -> Option<&StoredHead> {
        self.places.get(run).map(|place| &place.head)
    }

    /// Number of runs.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// True if no run has been taken in.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The rows of a run.
    ///
    /// # Errors
    /// If the run has not been taken in, or its rows cannot be read or are damaged.
    pub fn run(&self, run: &str) -> Result<StoredRun> {
        let Some(place) = self.places.get(run) else {
            return Err(Error::Rule(format!("the rows of the run {run} have not been taken in")));
        };
        let path = &self.files[place.file];
        let read = || -> std::io::Result<Vec<u8>> {
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start(place.start))?;
            let mut bytes = Vec::new();
            file.take(place.length).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        let bytes = read().map_err(Error::file("read", path))?;
        let whole = sha256(&bytes) == place.head.sha256;
        StoredRun::decode(&bytes).filter(|_| whole).ok_or_else(|| {
            let message = format!(
                "the rows of the run {run} were changed or damaged; remove the file, and the same command runs what is missing again"
            );
            Error::content(path, message)
        })
    }
}

/// The heads in a file with the places of their rows. The end that a killed process left unfinished is passed over.
fn heads(path: &Path) -> std::io::Result<Vec<(StoredHead, u64, u64)>> {
    let file = File::open(path)?;
    let size = file.metadata()?.len();
    let mut file = BufReader::with_capacity(1 << 13, file);
    let mut found = Vec::new();
    let mut beginning = [0; BEGINNING.len()];
    if size < BEGINNING.len() as u64 {
        return Ok(found);
    }
    file.read_exact(&mut beginning)?;
    if beginning != BEGINNING {
        return Ok(found);
    }
    let mut at = BEGINNING.len() as u64;
    while at + 16 <= size {
        let mut lengths = [0; 16];
        file.read_exact(&mut lengths)?;
        let number = |k: usize| u64::from_le_bytes(std::array::from_fn(|byte| lengths[8 * k + byte]));
        let (head, rows) = (number(0), number(1));
        if head > LONGEST_HEAD {
            break;
        }
        let start = at + 16 + head;
        let Some(end) = start.checked_add(rows).filter(|end| *end <= size) else { break };
        let mut text = vec![0; head as usize];
        file.read_exact(&mut text)?;
        if let Ok(head) = serde_json::from_slice::<StoredHead>(&text) {
            found.push((head, start, rows));
        }
        file.seek_relative(rows as i64)?;
        at = end;
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::super::{RowWriter, some_run};
    use super::*;

    #[test]
    fn runs_are_found_again_however_a_file_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = RowWriter::new(folder.path());
        assert!(RowFiles::read(folder.path()).unwrap().is_empty());
        let path = folder.path().join("rows/0001.rows");
        let mut ends = Vec::new();
        for (name, friction) in [("a", 0.1), ("b", 0.2), ("c", 0.3)] {
            writer.append(&[(name.into(), some_run(friction))]).unwrap();
            ends.push(std::fs::metadata(&path).unwrap().len() as usize);
        }
        let files = RowFiles::read(folder.path()).unwrap();
        assert_eq!(files.len(), 3);
        assert_eq!(files.run("b").unwrap().measured, some_run(0.2).measured);
        assert_eq!(files.head("b").unwrap().case_digest, some_run(0.2).record.case_digest);
        assert!(files.run("d").unwrap_err().to_string().contains("d have not been taken in"));
        let whole = std::fs::read(&path).unwrap();
        for length in (0..whole.len()).step_by(7) {
            std::fs::write(&path, &whole[..length]).unwrap();
            // Whoever goes on begins a file of its own.
            let second = folder.path().join("rows/0002.rows");
            let _ = std::fs::remove_file(&second);
            RowWriter::new(folder.path()).append(&[("e".into(), some_run(0.5))]).unwrap();
            let files = RowFiles::read(folder.path()).unwrap();
            assert!(second.is_file() && files.head("e").is_some());
            let complete = ends.iter().filter(|end| **end <= length).count();
            assert_eq!(files.len(), 1 + complete, "{length} of {}", whole.len());
            for name in ["a", "b", "c"] {
                assert!(files.head(name).is_none() || files.run(name).is_ok());
            }
        }
    }

    #[test]
    fn changed_rows_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        RowWriter::new(folder.path()).append(&[("a".into(), some_run(0.1))]).unwrap();
        let path = folder.path().join("rows/0001.rows");
        let mut bytes = std::fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let error = RowFiles::read(folder.path()).unwrap().run("a").unwrap_err().to_string();
        assert!(error.contains("0001.rows") && error.contains("run a were changed or damaged"), "{error}");
    }
}
