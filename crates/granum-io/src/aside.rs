//! The replacement of the files of a folder as one step or not at all: the old files are moved into a hidden folder beside
//! them, and go when the new ones have begun. If one cannot be moved, or the process is killed before, all of them return.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Folder of the files that are being replaced. If it exists when a folder is locked, the replacement was cut short.
pub(crate) const ASIDE: &str = ".granum-replaced";
/// The same folder once the replacement is settled.
pub(crate) const GOING: &str = ".granum-going";

/// Moves files (names relative to `folder`, in this order) out of the way; those that do not exist are left out. Inner folders
/// that are then empty are removed.
///
/// # Errors
/// [`Error::File`] if one cannot be moved; all of them are then where they were.
pub(crate) fn set_aside(folder: &Path, names: &[String]) -> Result<()> {
    let aside = folder.join(ASIDE);
    fs::create_dir(&aside).map_err(Error::file("create the folder", &aside))?;
    let mut moved: Vec<&String> = Vec::new();
    for name in names.iter().filter(|name| fs::symlink_metadata(folder.join(name)).is_ok()) {
        match move_file(&folder.join(name), &aside.join(name)) {
            Ok(()) => moved.push(name),
            Err(error) => {
                for name in moved.iter().rev() {
                    // The first error is the one to report.
                    let _ = fs::rename(aside.join(name), folder.join(name));
                }
                let _ = remove_empty(&aside);
                return Err(Error::file("replace", &folder.join(name))(error));
            }
        }
    }
    for inner in
        moved.iter().filter_map(|name| Path::new(name).parent().filter(|p| !p.as_os_str().is_empty()))
    {
        // A folder that holds other files stays.
        let _ = fs::remove_dir(folder.join(inner));
    }
    Ok(())
}

/// Ends a replacement: the old files go.
///
/// # Errors
/// [`Error::File`] if the folder cannot be changed.
pub(crate) fn settle(folder: &Path) -> Result<()> {
    let (aside, going) = (folder.join(ASIDE), folder.join(GOING));
    fs::rename(&aside, &going).map_err(Error::file("rename", &aside))?;
    fs::remove_dir_all(&going).map_err(Error::file("remove", &going))
}

/// Puts the old files back, over whatever took their places, and completes settled replacements. Only for the holder of the
/// folder's lock.
///
/// # Errors
/// [`Error::File`] if a file cannot be moved.
pub(crate) fn recover(folder: &Path) -> Result<()> {
    let going = folder.join(GOING);
    if is_real_folder(&going) {
        fs::remove_dir_all(&going).map_err(Error::file("remove", &going))?;
    }
    let aside = folder.join(ASIDE);
    if is_real_folder(&aside) {
        move_back(&aside, folder).map_err(Error::file("put back the files of", &aside))?;
    }
    Ok(())
}

/// True if a replacement in the folder was cut short, so that the old files are not in their places.
pub(crate) fn is_pending(folder: &Path) -> bool {
    is_real_folder(&folder.join(ASIDE))
}

fn is_real_folder(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|kind| kind.is_dir())
}

fn move_file(from: &Path, to: &Path) -> io::Result<()> {
    if let Some(parent) = to.parent() {
        fs::create_dir_all(parent)?;
    }
    fs::rename(from, to)
}

fn move_back(from: &Path, to: &Path) -> io::Result<()> {
    let entries: Vec<PathBuf> =
        fs::read_dir(from)?.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<_>>()?;
    for path in entries {
        let Some(name) = path.file_name() else { continue };
        if is_real_folder(&path) {
            fs::create_dir_all(to.join(name))?;
            move_back(&path, &to.join(name))?;
        } else {
            fs::rename(&path, to.join(name))?;
        }
    }
    fs::remove_dir(from)
}

fn remove_empty(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if is_real_folder(&path) {
            remove_empty(&path)?;
        }
    }
    fs::remove_dir(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(ToString::to_string).collect()
    }

    fn folder() -> tempfile::TempDir {
        let base = tempfile::tempdir().unwrap();
        fs::create_dir_all(base.path().join("snapshots")).unwrap();
        for name in ["run.json", "series.parquet", "snapshots/end.json", "snapshots/my.json"] {
            fs::write(base.path().join(name), name).unwrap();
        }
        base
    }

    const OLD: [&str; 4] = ["series.parquet", "snapshots/end.json", "histograms/x.parquet", "run.json"];

    #[test]
    fn what_is_settled_is_gone_and_all_else_stays() {
        let base = folder();
        set_aside(base.path(), &names(&OLD)).unwrap();
        assert!(!base.path().join("run.json").exists() && is_pending(base.path()));
        settle(base.path()).unwrap();
        recover(base.path()).unwrap();
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 1);
        assert_eq!(fs::read(base.path().join("snapshots/my.json")).unwrap(), b"snapshots/my.json");
        assert!(!base.path().join("snapshots/end.json").exists());
    }

    #[test]
    fn what_is_cut_short_comes_back_over_what_took_its_place() {
        let base = folder();
        fs::remove_file(base.path().join("snapshots/my.json")).unwrap();
        set_aside(base.path(), &names(&OLD)).unwrap();
        assert!(!base.path().join("snapshots").exists());
        fs::write(base.path().join("run.json"), "new").unwrap();
        recover(base.path()).unwrap();
        for name in ["run.json", "series.parquet", "snapshots/end.json"] {
            assert_eq!(fs::read(base.path().join(name)).unwrap(), name.as_bytes());
        }
        assert!(!is_pending(base.path()));
        // Killed between the two steps of the end.
        set_aside(base.path(), &names(&OLD)).unwrap();
        fs::rename(base.path().join(ASIDE), base.path().join(GOING)).unwrap();
        recover(base.path()).unwrap();
        assert!(!base.path().join("run.json").exists() && !base.path().join(GOING).exists());
    }

    #[test]
    fn a_file_that_cannot_be_moved_leaves_all_in_place() {
        let base = folder();
        // A folder cannot be renamed by the name that it has inside another.
        let list = names(&["series.parquet", "snapshots/end.json", "snapshots/..", "run.json"]);
        let error = set_aside(base.path(), &list).unwrap_err().to_string();
        assert!(error.starts_with("cannot replace") && error.contains("snapshots/.."), "{error}");
        for name in ["run.json", "series.parquet", "snapshots/end.json", "snapshots/my.json"] {
            assert_eq!(fs::read(base.path().join(name)).unwrap(), name.as_bytes());
        }
        assert!(!is_pending(base.path()) && !base.path().join(ASIDE).exists());
    }
}
