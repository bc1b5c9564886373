//! The runs in folders.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use granum_io::{Error, Result, Run, RunKind};

use crate::queue::RunList;

/// Depth to which folders are searched.
const DEPTH: usize = 6;

/// The runs in the given folders: folders of runs themselves, in their order, and those that contain runs, which are searched. The
/// order of a list of runs is kept, otherwise runs are sorted by name. Samples are left out where there are tests beside them;
/// symbolic links are not followed.
///
/// # Errors
/// If a folder does not exist or contains no run, or a folder in it has the series of a run without its record.
pub fn find_runs(folders: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found: Vec<PathBuf> = Vec::new();
    let mut known: HashSet<PathBuf> = HashSet::new();
    for folder in folders {
        if !folder.is_dir() {
            return Err(Error::content(folder, "there is no such folder"));
        }
        let mut inside = Vec::new();
        search(folder, DEPTH, &mut inside)?;
        if inside.is_empty() {
            return Err(Error::content(folder, "contains no run"));
        }
        let is_test = |run: &PathBuf| {
            Run::at(run).and_then(|run| run.record()).map_or(true, |record| record.kind != RunKind::Sample)
        };
        if inside.len() > 1 && inside.iter().any(is_test) {
            inside.retain(is_test);
        }
        found.extend(inside.into_iter().filter(|run| known.insert(run.clone())));
    }
    Ok(found)
}

fn search(folder: &Path, depth: usize, found: &mut Vec<PathBuf>) -> Result<()> {
    let there = |name: &str| folder.join(name).symlink_metadata().is_ok();
    if there("run.json") {
        found.push(folder.to_path_buf());
        return Ok(());
    }
    // A run must not be left out of a table without a word.
    if there("series.parquet") {
        return Err(Error::content(
            folder,
            "holds the series of a run but no run.json; put the file back, or remove the folder",
        ));
    }
    if depth == 0 {
        return Ok(());
    }
    let mut inside: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(Error::file("read", folder))? {
        let entry = entry.map_err(Error::file("read", folder))?;
        // A link is not a folder here.
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            inside.push(entry.path());
        }
    }
    let listed: Vec<PathBuf> = match RunList::read(folder)? {
        Some(list) => list.tests(folder).map(|(_, path)| path).collect(),
        None => Vec::new(),
    };
    let place = |path: &PathBuf| listed.iter().position(|known| known == path).unwrap_or(listed.len());
    inside.sort_by(|a, b| place(a).cmp(&place(b)).then_with(|| a.cmp(b)));
    inside.iter().try_for_each(|path| search(path, depth - 1, found))
}
