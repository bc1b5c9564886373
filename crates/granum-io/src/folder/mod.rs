//! Output folders: nothing is replaced unless requested, and only one process at a time works in a folder.

mod lock;
mod names;
pub mod process;
#[cfg(test)]
mod tests;

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

pub(crate) use self::lock::LOCK;
use self::lock::{is_lock, take};
use self::names::LINK;
pub use self::names::{check_name, check_new_file, check_output_file, inner_folder};
use crate::aside;
use crate::atomic::{UNFINISHED, remove_unfinished};
use crate::error::{Error, Result};
use crate::run::CHECKPOINT;
use crate::windows_names;

/// Files by one of which a folder is known as granum's if its lock file was not copied with it.
const RECORDS: [&str; 6] =
    ["run.json", "runs.json", "campaign.json", "training.json", "study.json", "reproduction.json"];
/// Largest of them that is looked into.
const LARGEST_RECORD: u64 = 1 << 24;
/// A folder that is used by this process alone, until the value is dropped.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Holds the lock as long as it is open.
    _lock: File,
}

impl OutputFolder {
    /// Creates a folder, or takes over an empty one. With `force`, a folder that granum wrote before is also accepted; its
    /// content remains until [`OutputFolder::clear`] is called or a file of the same name is written.
    ///
    /// # Errors
    /// [`Error::Content`] if it contains files that are not granum's; [`Error::Exists`] if it is granum's and `force` is not
    /// set; [`Error::Locked`] if another process is using it; [`Error::File`] if it cannot be created.
    pub fn create(path: impl AsRef<Path>, force: bool) -> Result<OutputFolder> {
        let path = path.as_ref();
        windows_names::check_path(path)?;
        if force {
            refuse_link(path)?;
        }
        fs::create_dir_all(path).map_err(Error::file("create the folder", path))?;
        // Checked before there is a lock file, so that a foreign folder is left unchanged.
        let granum = is_granums(path);
        if !granum && !is_empty(path)? {
            return Err(Error::content(
                path,
                "contains files that granum did not write; choose another folder",
            ));
        }
        let folder = OutputFolder::lock(path)?;
        if !force && !is_empty(path)? {
            return Err(Error::Exists(path.to_path_buf()));
        }
        Ok(folder)
    }

    /// Opens a folder that granum wrote before, to continue in it.
    ///
    /// # Errors
    /// [`Error::Content`] if it is not granum's; [`Error::Locked`] if another process is using it.
    pub fn open(path: impl AsRef<Path>) -> Result<OutputFolder> {
        let path = path.as_ref();
        if !path.is_dir() {
            return Err(Error::content(path, "there is no such folder"));
        }
        if !is_granums(path) {
            let message = format!(
                "is not a folder that granum wrote: it has neither {LOCK} nor one of {} that can be read; copy folders with all \
                 of their files",
                RECORDS.join(", ")
            );
            return Err(Error::content(path, message));
        }
        OutputFolder::lock(path)
    }

    /// True if the folder is free: it does not exist, or contains nothing except what a process left that was killed at its
    /// start.
    pub fn is_free(path: impl AsRef<Path>) -> bool {
        let path = path.as_ref();
        !path.is_dir() || is_empty(path).unwrap_or(false)
    }

    /// True if the folder was written by granum.
    pub fn is_granums(path: impl AsRef<Path>) -> bool {
        is_granums(path.as_ref())
    }

    /// True if a process is using the folder; nothing is created or changed.
    pub fn is_in_use(path: impl AsRef<Path>) -> bool {
        let name = path.as_ref().join(LOCK);
        let held = |file: File| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
        is_lock(&name) && File::open(name).is_ok_and(held)
    }

    /// The process that uses the folder, in words, as its lock file names it; `None` if none does.
    pub fn user(path: impl AsRef<Path>) -> Option<String> {
        let path = path.as_ref();
        let text =
            OutputFolder::is_in_use(path).then(|| fs::read_to_string(path.join(LOCK)).unwrap_or_default())?;
        Some(text.trim().parse::<u32>().map_or_else(|_| "another process".into(), process::in_words))
    }

    /// Opens a folder of granum's to continue in it, or creates it.
    ///
    /// # Errors
    /// As for [`OutputFolder::open`] and [`OutputFolder::create`].
    pub fn open_or_create(path: impl AsRef<Path>) -> Result<OutputFolder> {
        let path = path.as_ref();
        if is_granums(path) { OutputFolder::open(path) } else { OutputFolder::create(path, false) }
    }

    fn lock(path: &Path) -> Result<OutputFolder> {
        let file = take(path, remove_unfinished)?;
        aside::recover(path)?;
        Ok(OutputFolder { path: path.to_path_buf(), _lock: file })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Creates a folder inside.
    ///
    /// # Errors
    /// As for [`inner_folder`].
    pub fn subfolder(&self, name: &str) -> Result<PathBuf> {
        inner_folder(&self.path, name)
    }

    /// Rejects a folder that contains links in place of its inner folders: files written there would end up elsewhere.
    ///
    /// # Errors
    /// [`Error::Content`] with the name of the link.
    pub fn refuse_links(&self, names: &[&str]) -> Result<()> {
        let link = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|kind| kind.is_symlink());
        match names.iter().map(|name| self.path.join(name)).find(link) {
            Some(path) => Err(Error::content(&path, LINK)),
            None => Ok(()),
        }
    }

    /// Replaces files of these names (relative, inner folders included) by what `write` writes: the old ones are moved out of the
    /// way, and go once `write` has succeeded. If one of them cannot be moved, if `write` fails, or if the process is killed, the
    /// old files are where they were, in the last case from the next time on that the folder is opened.
    ///
    /// # Errors
    /// [`Error::File`] if a file cannot be moved, and the errors of `write`.
    pub fn replace<T, E: From<Error>>(
        &self,
        names: &[String],
        write: impl FnOnce() -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        aside::set_aside(&self.path, names)?;
        match write() {
            Ok(written) => {
                aside::settle(&self.path)?;
                Ok(written)
            }
            Err(error) => {
                aside::recover(&self.path)?;
                Err(error)
            }
        }
    }

    /// Removes files and folders of these names, if they exist. Links are removed, not followed.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be removed.
    pub fn clear(&self, names: &[&str]) -> Result<()> {
        for name in names {
            let path = self.path.join(name);
            let Ok(kind) = fs::symlink_metadata(&path) else { continue };
            let removed = if kind.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            removed.map_err(Error::file("remove", &path))?;
        }
        Ok(())
    }

    /// Removes temporary files that a killed process left in an inner folder.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be removed.
    pub fn remove_unfinished_inside(&self, name: &str) -> Result<()> {
        let path = self.path.join(name);
        if !fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_dir()) {
            return Ok(());
        }
        remove_unfinished(&path).map_err(Error::file("tidy", &path))
    }

    /// Removes the files of these names from an inner folder, with what a killed process left there, and the folder if it is then
    /// empty. Folders, and a link in its place, are left alone.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be removed.
    pub fn clear_inside(&self, name: &str, files: &[String]) -> Result<()> {
        let path = self.path.join(name);
        if !fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_dir()) {
            return Ok(());
        }
        self.remove_unfinished_inside(name)?;
        for file in files.iter().map(|file| path.join(file)) {
            if fs::symlink_metadata(&file).is_ok_and(|kind| !kind.is_dir()) {
                fs::remove_file(&file).map_err(Error::file("remove", &file))?;
            }
        }
        let is_empty = fs::read_dir(&path).map_err(Error::file("read", &path))?.next().is_none();
        if is_empty { fs::remove_dir(&path).map_err(Error::file("remove", &path)) } else { Ok(()) }
    }
}

/// True if granum wrote the folder: it has the lock file, or one of granum's records where the lock file was not copied with the
/// other files. A lock file that is a link or anything else does not count.
fn is_granums(path: &Path) -> bool {
    let lock = path.join(LOCK);
    is_lock(&lock)
        || (fs::symlink_metadata(&lock).is_err() && RECORDS.iter().any(|name| is_record(&path.join(name))))
}

/// True for a file that names granum as its writer.
fn is_record(path: &Path) -> bool {
    if !fs::symlink_metadata(path).is_ok_and(|kind| kind.is_file()) {
        return false;
    }
    let text = crate::text::read_small(path, LARGEST_RECORD).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let format = value["format"].as_str().is_some_and(|format| format.starts_with("granum "));
    format || value["granum_version"].is_string()
}

/// Refuses to replace the content of a folder through a link, which may point anywhere.
fn refuse_link(path: &Path) -> Result<()> {
    // Without the slash at the end that would make the system follow the link.
    let own: PathBuf = path.components().collect();
    if fs::symlink_metadata(&own).is_ok_and(|kind| kind.is_symlink()) {
        let message =
            "is a symbolic link, which --force does not follow; name the folder itself, or another one";
        return Err(Error::content(path, message));
    }
    Ok(())
}

/// True if the folder contains nothing except the lock and leftovers of a killed process: unfinished files, and beside a lock the first
/// checkpoint of a run that has no record yet.
fn is_empty(path: &Path) -> Result<bool> {
    let is_locked = is_lock(&path.join(LOCK));
    for entry in fs::read_dir(path).map_err(Error::file("read", path))? {
        let name = entry.map_err(Error::file("read", path))?.file_name();
        let name = name.to_string_lossy();
        let is_leftover = name.ends_with(UNFINISHED) || (is_locked && name == CHECKPOINT);
        if name != LOCK && name != aside::GOING && !is_leftover {
            return Ok(false);
        }
    }
    Ok(true)
}
