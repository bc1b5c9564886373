//! The folder of a run, for writing.
//!
//! Files are written in a hidden folder first. Before they are moved to their places, the record gets their SHA-256 beside those
//! of the files that they replace, so that at every instant each file is one that the record knows.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use granum_core::Table;
use granum_core::assembly::Assembly;
use granum_sensors::RecordedState;

use super::content::{
    self, CASE, CHECKPOINT, FOLDERS, FORCES, HISTOGRAMS, PREPARATION, PREVIOUS_CHECKPOINT,
    REFUSED_CHECKPOINT, SERIES, SNAPSHOTS,
};
use super::file_digest::{RECORD, file_digest};
use super::record::{RUN_FORMAT, RunRecord};
use super::states::{self, STATES};
use super::{Run, times};
use crate::atomic::{STAGING, sync_folder, write_atomically, write_keeping_previous};
use crate::case::Case;
use crate::error::{Error, Result};
use crate::folder::{OutputFolder, check_name};
use crate::sealed::write_sealed;
use crate::snapshot;

/// The folder of a run, for writing; it is locked until this value is dropped.
#[derive(Debug)]
pub struct RunFolder {
    folder: OutputFolder,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// The record in the folder.
    record: Option<RunRecord>,
    /// SHA-256 of the files in the folder.
    content: BTreeMap<String, String>,
    /// Files of a previous run that the first file of this run replaces.
    old: Vec<String>,
}

impl RunFolder {
    /// Creates the folder of a new run. With `force` a previous run in it is replaced when the first file is written, as one step
    /// or not at all; files that granum did not write stay.
    ///
    /// # Errors
    /// As for [`OutputFolder::create`].
    pub fn create(path: impl AsRef<Path>, force: bool) -> Result<RunFolder> {
        let folder = OutputFolder::create(path, force)?;
        folder.refuse_links(&FOLDERS)?;
        let record = Run::in_folder(folder.path()).record().ok();
        let old = content::written(folder.path(), record.as_ref());
        Ok(RunFolder { folder, state: Mutex::new(State { old, ..State::default() }) })
    }

    /// Opens the folder of a run to continue it.
    ///
    /// # Errors
    /// As for [`OutputFolder::open`].
    pub fn open(path: impl AsRef<Path>) -> Result<RunFolder> {
        let folder = OutputFolder::open(path)?;
        folder.refuse_links(&FOLDERS)?;
        for name in FOLDERS {
            folder.remove_unfinished_inside(name)?;
        }
        // A record that cannot be read is refused by whoever continues the run.
        let record = Run::in_folder(folder.path()).record().ok();
        let content = record.as_ref().map(|record| content_on_disk(folder.path(), record)).transpose()?;
        let record = record.map(|record| named_from(folder.path(), record)).transpose()?;
        let state = State { record, content: content.unwrap_or_default(), old: Vec::new() };
        Ok(RunFolder { folder, state: Mutex::new(state) })
    }

    /// Removes the previous run that the folder was created over; otherwise the first file that is written replaces it.
    ///
    /// # Errors
    /// [`Error::File`] if a file cannot be removed; all are then still there.
    pub fn remove_previous(&self) -> Result<()> {
        self.replacing(|| Ok(()))
    }

    /// Calls `write`, which writes the first files of a run: a previous run that they replace goes when all of them are there.
    ///
    /// # Errors
    /// Those of `write`, and [`Error::File`] if the previous run cannot be replaced.
    pub fn as_one(&self, write: impl FnOnce() -> Result<()>) -> Result<()> {
        self.replacing(write)
    }

    /// Writes a checkpoint through `fill`; the previous one is kept as [`PREVIOUS_CHECKPOINT`].
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written; both existing checkpoints are then unchanged.
    pub fn write_checkpoint(&self, fill: impl FnOnce(&mut dyn io::Write) -> io::Result<()>) -> Result<()> {
        let previous = self.folder.file(PREVIOUS_CHECKPOINT);
        self.replacing(|| write_keeping_previous(&self.folder.file(CHECKPOINT), &previous, |file| fill(file)))
    }

    /// Renames a checkpoint that cannot be used to [`REFUSED_CHECKPOINT`].
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be renamed.
    pub fn put_checkpoint_aside(&self) -> Result<()> {
        let path = self.folder.file(CHECKPOINT);
        if !path.exists() {
            return Ok(());
        }
        fs::rename(&path, self.folder.file(REFUSED_CHECKPOINT)).map_err(Error::file("rename", &path))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The same folder for reading.
    pub fn run(&self) -> Run {
        Run::in_folder(self.folder.path())
    }

    /// Writes the resolved case, with the name of the packing that replaces the random insertion, if there is one.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_case(&self, case: &Case, packing: Option<&str>) -> Result<()> {
        let text = case.resolved_toml_with(packing);
        self.replacing(|| {
            write_atomically(&self.folder.file(CASE), |file| io::Write::write_all(file, text.as_bytes()))
        })
    }

    /// Writes the history of the preparation.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::write`].
    pub fn write_preparation(&self, table: &Table) -> Result<()> {
        self.write_table(None, PREPARATION, table)
    }

    /// Writes the table of states.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::write`].
    pub fn write_series(&self, table: &Table) -> Result<()> {
        self.write_table(None, SERIES, table)
    }

    /// Writes the table of force histograms.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::write`].
    pub fn write_forces(&self, table: &Table) -> Result<()> {
        self.write_table(None, FORCES, table)
    }

    /// Writes the table of another histogram than that of the forces.
    ///
    /// # Errors
    /// As [`crate::formats::parquet::write`]; [`Error::Value`] if the name is no plain word.
    pub fn write_histogram(&self, name: &str, table: &Table) -> Result<()> {
        check_name("histogram", name)?;
        self.write_table(Some(HISTOGRAMS), &format!("{name}.parquet"), table)
    }

    /// Writes the file of the states of a test that is under way, with those that were recorded before.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_states(&self, recorded: &[RecordedState]) -> Result<()> {
        self.replacing(|| states::write(&self.folder.file(STATES), recorded))
    }

    /// Appends a state that was recorded to their file.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn append_state(&self, state: &RecordedState) -> Result<()> {
        states::append(&self.folder.file(STATES), state)
    }

    /// Removes the file of the states, once the tables of the test have them all.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be removed.
    pub fn remove_states(&self) -> Result<()> {
        states::remove(&self.folder.file(STATES))
    }

    /// Writes a snapshot, e.g. `sample` or `end`.
    ///
    /// # Errors
    /// As for [`snapshot::write_snapshot`]; [`Error::Value`] if the name is not a plain word.
    pub fn write_snapshot(&self, name: &str, assembly: &Assembly) -> Result<()> {
        check_name("snapshot", name)?;
        let further = (!assembly.all_spheres()).then_some(snapshot::pieces::FILE);
        let bonds = assembly.is_bonded().then_some(snapshot::bonds::FILE);
        let parts = snapshot::PARTS.into_iter().chain(further).chain(bonds);
        let files: Vec<String> = parts.map(|end| format!("{name}.{end}")).collect();
        self.put(Some(SNAPSHOTS), &files, |staging| snapshot::write_snapshot(staging, name, assembly))
    }

    /// Writes the record, with the SHA-256 of the files of the run.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_record(&self, record: &RunRecord) -> Result<()> {
        self.replacing(|| {
            // Folders that are moved together find each other again.
            let mut record = named_from(self.folder.path(), record.clone())?;
            record.format = RUN_FORMAT;
            let mut state = self.state();
            record.content = state.content.clone();
            record.replaced = BTreeMap::new();
            // The record comes first: a folder in which the disk was full or the process was killed before it is an empty one.
            write_sealed(&self.folder.file(RECORD), &record)?;
            times::write(self.folder.path(), &record)?;
            state.record = Some(record);
            Ok(())
        })
    }

    /// Refuses a folder from which a file was removed since the run wrote it.
    ///
    /// # Errors
    /// [`Error::Content`] with the name of the file.
    pub fn check_present(&self) -> Result<()> {
        let missing =
            self.state().content.keys().map(|name| self.folder.file(name)).find(|path| !path.is_file());
        match missing {
            None => Ok(()),
            Some(path) => {
                Err(Error::content(&path, "was removed while the run was under way; run the case again"))
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `write`; the first time, what it writes replaces the files of the previous run.
    fn replacing(&self, write: impl FnOnce() -> Result<()>) -> Result<()> {
        let old = std::mem::take(&mut self.state().old);
        if !old.iter().any(|name| fs::symlink_metadata(self.folder.file(name)).is_ok()) {
            return write();
        }
        let result = self.folder.replace(&old, write);
        if result.is_err() {
            self.state().old = old;
        }
        result
    }

    fn write_table(&self, inner: Option<&str>, file: &str, table: &Table) -> Result<()> {
        self.put(inner, &[file.to_string()], |staging| {
            crate::formats::parquet::write(&staging.join(file), table)
        })
    }

    /// Writes files into a folder of their own, notes their SHA-256 in the record, and moves them to their places.
    fn put(
        &self,
        inner: Option<&str>,
        files: &[String],
        write: impl FnOnce(&Path) -> Result<()>,
    ) -> Result<()> {
        self.replacing(|| {
            let target = match inner {
                Some(inner) => self.folder.subfolder(inner)?,
                None => self.folder.path().to_path_buf(),
            };
            let staging = self.folder.file(STAGING);
            fs::create_dir_all(&staging).map_err(Error::file("create the folder", &staging))?;
            let written = write(&staging).and_then(|()| self.place(inner, files, &staging, &target));
            // What is left of a failed attempt must not be there for the next one.
            let removed = fs::remove_dir_all(&staging).map_err(Error::file("remove", &staging));
            written.map_err(|error| named_by_place(error, &staging, &target)).and(removed)
        })
    }

    fn place(&self, inner: Option<&str>, files: &[String], staging: &Path, target: &Path) -> Result<()> {
        let mut new = BTreeMap::new();
        for file in files {
            let name = inner.map_or_else(|| file.clone(), |inner| format!("{inner}/{file}"));
            new.insert(name, file_digest(&staging.join(file))?);
        }
        let mut state = self.state();
        if new.iter().any(|(name, digest)| state.content.get(name) != Some(digest)) {
            self.announce(&state, &new)?;
        }
        for file in files {
            let path = target.join(file);
            fs::rename(staging.join(file), &path).map_err(Error::file("write", &path))?;
        }
        sync_folder(&target.join("x")).map_err(Error::file("write", target))?;
        state.content.extend(new);
        Ok(())
    }

    /// Notes in the record, if there is one yet, files that are about to be moved to their places.
    fn announce(&self, state: &State, new: &BTreeMap<String, String>) -> Result<()> {
        let Some(mut record) = state.record.clone() else { return Ok(()) };
        let before = |name: &String| state.content.get(name).cloned().unwrap_or_default();
        record.replaced = new.keys().map(|name| (name.clone(), before(name))).collect();
        record.content = state.content.clone();
        record.content.extend(new.clone());
        record.format = RUN_FORMAT;
        write_sealed(&self.folder.file(RECORD), &record)
    }
}

/// A record as its folder holds it.
fn named_from(folder: &Path, record: RunRecord) -> Result<RunRecord> {
    Ok(RunRecord { source: record.source.relative_to(folder)?, ..record })
}

/// SHA-256 of the files of a run that is opened, by the record; files on which the process was killed are looked at, and so are
/// those of an earlier version that its record does not list.
fn content_on_disk(folder: &Path, record: &RunRecord) -> Result<BTreeMap<String, String>> {
    let mut content = record.content.clone();
    for (name, before) in &record.replaced {
        let path = folder.join(name);
        if !path.is_file() && before.is_empty() {
            content.remove(name);
        } else if path.is_file() && file_digest(&path)? == *before {
            content.insert(name.clone(), before.clone());
        }
    }
    if !record.lists_all() {
        let snapshots = content::usual_snapshots(folder);
        let files = snapshots.iter().flat_map(|name| content::snapshot_files(name));
        for name in files.chain(content::TABLES.map(String::from)) {
            let path = folder.join(&name);
            if path.is_file() && !content.contains_key(&name) {
                content.insert(name, file_digest(&path)?);
            }
        }
    }
    Ok(content)
}

/// An error about a file in the folder where it is written first, named by the place where it belongs.
fn named_by_place(error: Error, staging: &Path, target: &Path) -> Error {
    let place = |path: PathBuf| path.strip_prefix(staging).map(|name| target.join(name)).unwrap_or(path);
    match error {
        Error::File { action, path, source } => Error::File { action, path: place(path), source },
        Error::Content { path, message } => Error::Content { path: place(path), message },
        other => other,
    }
}
