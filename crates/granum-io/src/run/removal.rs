//! The removal of a run with its folder.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::content;
use super::run_folder::RunFolder;
use crate::error::{Error, Result};
use crate::folder::LOCK;

impl RunFolder {
    /// Removes the run with its folder. It is first moved into the folder `aside`, which is on the same disk, so that wherever the process
    /// is killed the run is whole in its place or gone from it; whoever uses `aside` removes what is left there.
    ///
    /// # Errors
    /// [`Error::Content`] if the folder holds a file that granum did not write, which is named; the run then stays. [`Error::File`] if
    /// it cannot be moved or removed.
    pub fn remove(self, aside: &Path) -> Result<()> {
        let path = self.path().to_path_buf();
        let record = self.run().record().ok();
        let mut known: BTreeSet<PathBuf> =
            content::written(&path, record.as_ref()).into_iter().map(PathBuf::from).collect();
        known.insert(LOCK.into());
        if let Some(other) = other_file(&path, Path::new(""), &known)? {
            let message = "was not written by granum, so that the folder of its run stays";
            return Err(Error::content(&path.join(other), message));
        }
        fs::create_dir_all(aside).map_err(Error::file("create the folder", aside))?;
        let name = path.file_name().ok_or_else(|| Error::content(&path, "has no name"))?;
        let moved = aside.join(name);
        if moved.symlink_metadata().is_ok() {
            fs::remove_dir_all(&moved).map_err(Error::file("remove", &moved))?;
        }
        fs::rename(&path, &moved).map_err(Error::file("move", &path))?;
        fs::remove_dir_all(&moved).map_err(Error::file("remove", &moved))
    }
}

/// The first file in a folder, or in one inside, that is not among the known ones.
fn other_file(folder: &Path, inside: &Path, known: &BTreeSet<PathBuf>) -> Result<Option<PathBuf>> {
    let here = folder.join(inside);
    for entry in fs::read_dir(&here).map_err(Error::file("read", &here))? {
        let entry = entry.map_err(Error::file("read", &here))?;
        let name = inside.join(entry.file_name());
        let kind = entry.file_type().map_err(Error::file("read", &folder.join(&name)))?;
        if kind.is_dir() {
            if let Some(other) = other_file(folder, &name, known)? {
                return Ok(Some(other));
            }
        } else if !known.contains(&name) {
            return Ok(Some(name));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::super::{Machine, RunKind, RunRecord};
    use super::*;
    use crate::case::Case;

    #[test]
    fn a_run_goes_with_its_folder_unless_it_holds_a_foreign_file() {
        let base = tempfile::tempdir().unwrap();
        let (run, aside) = (base.path().join("run"), base.path().join("aside"));
        let folder = RunFolder::create(&run, false).unwrap();
        folder
            .write_record(&RunRecord::new(RunKind::Test, "0.1.0", &Case::default(), Machine::default()))
            .unwrap();
        fs::create_dir(run.join("figures")).unwrap();
        fs::write(run.join("figures/mine.svg"), "mine").unwrap();
        let error = folder.remove(&aside).unwrap_err().to_string();
        assert!(error.contains("mine.svg: was not written by granum"), "{error}");
        assert!(run.join("run.json").is_file() && !aside.exists());
        fs::remove_file(run.join("figures/mine.svg")).unwrap();
        // What a killed process left of an earlier removal is no hindrance.
        fs::create_dir_all(aside.join("run/snapshots")).unwrap();
        RunFolder::open(&run).unwrap().remove(&aside).unwrap();
        assert!(!run.exists() && fs::read_dir(&aside).unwrap().next().is_none());
    }
}
