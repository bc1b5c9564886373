//! Files that exist completely or not at all: written under a temporary name in the same folder, flushed to the disk, then
//! renamed.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};
use crate::windows_names;

/// Suffix of the name of a file that is being written.
pub(crate) const UNFINISHED: &str = ".granum-unfinished";
/// Folder in which the files of a run are written before they are moved to their places.
pub(crate) const STAGING: &str = ".staging.granum-unfinished";
/// Number of names that are tried for a temporary file.
const MOST_NAMES: usize = 16;

/// Distinguishes temporary files that one process writes for the same name.
static COUNTER: AtomicU64 = AtomicU64::new(0);

/// The temporary files that this process is writing.
static UNFINISHED_NOW: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the temporary files that this process is writing, for a program that is about to end at once. Files that are complete stay.
pub fn abandon_writing() {
    for path in UNFINISHED_NOW.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        // A file that has just been renamed is complete and no longer there.
        let _ = fs::remove_file(path);
    }
}

/// A temporary file in the list of those that are being written, for as long as this lives.
struct Unfinished<'a>(&'a Path);

impl<'a> Unfinished<'a> {
    fn new(path: &'a Path) -> Unfinished<'a> {
        UNFINISHED_NOW.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_path_buf());
        Unfinished(path)
    }
}

impl Drop for Unfinished<'_> {
    fn drop(&mut self) {
        UNFINISHED_NOW.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| path != self.0);
    }
}

/// Writes a file through `fill`. If this returns `Ok`, the file is complete and on the disk; otherwise the previous file is
/// unchanged and no temporary file is left.
///
/// # Errors
/// [`Error::File`] if the folder cannot be written, the disk is full, or `fill` fails.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<()> {
    write_beside(path, fill, |beside| fs::rename(beside, path))
}

/// The same as [`write_atomically`], but the previous file is kept under another name in the same folder. If the process is
/// killed at any instant, the old or the new file is complete under one of the two names.
///
/// # Errors
/// As for [`write_atomically`].
pub fn write_keeping_previous(
    path: &Path,
    previous: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<()> {
    write_beside(path, fill, |beside| {
        match fs::rename(path, previous) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        fs::rename(beside, path)
    })
}

/// Fills a temporary file, flushes it to the disk and renames it.
fn write_beside(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
    place: impl FnOnce(&Path) -> io::Result<()>,
) -> Result<()> {
    windows_names::check_path(path)?;
    remove_left_by_killed(path);
    let (beside, file) = create_locked(path)?;
    let _unfinished = Unfinished::new(&beside);
    let write = || {
        fill_and_sync(&file, fill)?;
        place(&beside)?;
        sync_folder(path)
    };
    let result = write();
    if result.is_err() {
        // The first error is the one to report; a file that was never created cannot be removed either.
        let _ = fs::remove_file(&beside);
    }
    result.map_err(Error::file("write", path))
}

/// Creates a temporary file beside `path` and locks it as long as it is open, by which other processes know that it is in use.
fn create_locked(path: &Path) -> Result<(PathBuf, File)> {
    let mut beside = name_beside(path)?;
    for _ in 0..MOST_NAMES {
        let file = create_new(&beside).map_err(Error::file("write", path))?;
        match file.try_lock() {
            // Another process took the file for one that was left over, before it was locked.
            Ok(()) if fs::symlink_metadata(&beside).is_err() => {}
            Err(TryLockError::WouldBlock) => {}
            // Some file systems have no locks.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok((beside, file)),
        }
        beside = name_beside(path)?;
    }
    Err(Error::content(path, "cannot be written: other processes write it as well"))
}

/// Removes the temporary files of the same name that killed processes left: those that no process has locked. Nothing depends
/// on it, so that errors are passed over.
fn remove_left_by_killed(path: &Path) {
    let Some(name) = path.file_name().map(|name| format!(".{}.", name.to_string_lossy())) else { return };
    let Ok(entries) = fs::read_dir(folder_of(path)) else { return };
    for entry in entries.flatten() {
        let own = entry.file_name();
        let own = own.to_string_lossy();
        let middle = own.strip_prefix(name.as_str()).and_then(|rest| rest.strip_suffix(UNFINISHED));
        let is_temporary = middle.is_some_and(|middle| {
            !middle.is_empty() && middle.chars().all(|c| c.is_ascii_digit() || c == '-')
        });
        if !is_temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn fill_and_sync(file: &File, fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.sync_all()
}

/// Creates a new file: an existing one of that name is removed and not overwritten, since it may be a link.
fn create_new(path: &Path) -> io::Result<File> {
    match File::create_new(path) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            fs::remove_file(path)?;
            File::create_new(path)
        }
        result => result,
    }
}

/// A name in the same folder, so that the renaming stays on one file system.
fn name_beside(path: &Path) -> Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| Error::content(path, "is not a file name"))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}-{}{UNFINISHED}", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
    Ok(path.with_file_name(hidden))
}

/// Makes the renaming itself survive a power failure.
#[cfg(unix)]
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    File::open(folder_of(path))?.sync_all()
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(not(unix))]
pub(crate) fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Removes temporary files that a killed process left in a folder. Only for the holder of the folder's lock.
pub(crate) fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name == STAGING && entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else if name.starts_with('.') && name.ends_with(UNFINISHED) && entry.file_type()?.is_file() {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.json");
        write_atomically(&path, |file| file.write_all(b"old")).unwrap();
        let error = write_atomically(&path, |file| {
            file.write_all(b"half of the new")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(error.unwrap_err().to_string().ends_with("run.json: the disk is full"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn the_previous_file_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let (path, previous) = (folder.path().join("checkpoint"), folder.path().join("checkpoint.previous"));
        for text in ["one", "two", "three"] {
            write_keeping_previous(&path, &previous, |file| file.write_all(text.as_bytes())).unwrap();
        }
        assert_eq!(
            (fs::read(&path).unwrap(), fs::read(&previous).unwrap()),
            (b"three".into(), b"two".into())
        );
        let full = |_: &mut BufWriter<&File>| Err(io::Error::other("the disk is full"));
        assert!(write_keeping_previous(&path, &previous, full).is_err());
        assert_eq!(
            (fs::read(&path).unwrap(), fs::read(&previous).unwrap()),
            (b"three".into(), b"two".into())
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn what_a_killed_process_left_of_a_file_goes_when_the_file_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.csv");
        let left = folder.path().join(format!(".out.csv.4711-0{UNFINISHED}"));
        let at_work = folder.path().join(format!(".out.csv.4712-3{UNFINISHED}"));
        let other = folder.path().join(format!(".out.csv.bak.1-0{UNFINISHED}"));
        for file in [&left, &at_work, &other] {
            fs::write(file, "half").unwrap();
        }
        let held = File::options().write(true).open(&at_work).unwrap();
        held.lock().unwrap();
        write_atomically(&path, |file| file.write_all(b"whole")).unwrap();
        assert!(!left.exists() && at_work.exists() && other.exists() && path.exists());
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("nowhere").join("x.csv");
        let error = write_atomically(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(error.starts_with("cannot write") && error.contains("nowhere"), "{error}");
    }

    #[test]
    fn leftovers_of_a_killed_process_go_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(format!(".series.parquet.12-0{UNFINISHED}")), "x").unwrap();
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        remove_unfinished(folder.path()).unwrap();
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left, ["notes.txt"]);
    }
}
