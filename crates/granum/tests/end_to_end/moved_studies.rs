//! A reproduction and a calibration that are killed go on elsewhere, also in another file system.

use std::fs;
use std::path::{Path, PathBuf};

use crate::calibrations::folder;
use crate::moved_folders::{copy, holds_no_path, killed_when};
use crate::{digest, done, done_json};

/// A folder in another file system than that of temporary folders, where there is one in memory.
fn elsewhere() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

/// Runs below a folder that are finished.
fn finished(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_finished = |run: &PathBuf| {
        fs::read_to_string(run.join("run.json")).is_ok_and(|text| text.contains("\"status\": \"finished\""))
    };
    entries.map(|entry| entry.path()).filter(is_finished).collect()
}

fn has_checkpoint(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).any(|run| run.join("checkpoint").is_file())
}

/// A reproduction is killed at its first checkpoint, goes on in a copy elsewhere to its first finished run, and is killed again: that run
/// is the one that the same command makes in one go.
#[test]
fn a_reproduction_that_is_killed_goes_on_in_another_file_system() {
    let (base, other) = (tempfile::tempdir().unwrap(), elsewhere());
    let here = base.path();
    let out = here.join("quick").display().to_string();
    let command = ["reproduce", "--quick", "--checkpoint-every", "0.2", "--out", &out];
    killed_when(here, || has_checkpoint(&here.join("quick/runs")), &command);
    holds_no_path(&here.join("quick"), here);
    copy(&here.join("quick"), &other.path().join("moved"));
    let runs = other.path().join("moved/runs");
    killed_when(other.path(), || !finished(&runs).is_empty(), &["resume", "moved"]);
    holds_no_path(&other.path().join("moved"), other.path());
    let status = done_json(other.path(), &["status", "moved"]);
    assert_eq!(status["command"], "granum reproduce --quick --out moved", "{status:#}");
    // The case of a run is in its folder.
    let run = finished(&runs).remove(0);
    done(here, &["run", run.join("case.toml").to_str().unwrap(), "--out", "straight"]);
    let name = run.file_name().unwrap().to_str().unwrap().to_string();
    assert_eq!(digest(&runs, &name), digest(here, "straight"));
}

/// A calibration is killed while it simulates, and its folder goes on in a copy elsewhere to the same posterior.
#[test]
fn a_calibration_that_is_killed_goes_on_in_another_file_system() {
    let (base, other) = (folder(true), elsewhere());
    let here = base.path();
    let out = here.join("out").display().to_string();
    killed_when(
        here,
        || !finished(&here.join("out/runs/design/tests")).is_empty(),
        &["calibrate", "material.toml", "lab.csv", "--out", &out],
    );
    holds_no_path(&here.join("out"), here);
    let before = finished(&here.join("out/runs/design/tests")).len();
    assert!((1..16).contains(&before), "{before}");
    copy(here, &other.path().join("moved"));
    let moved = other.path().join("moved");
    let found = done_json(&moved, &["calibrate", "material.toml", "lab.csv", "--out", "out"]);
    holds_no_path(&moved.join("out"), &moved);
    let straight = done_json(here, &["calibrate", "material.toml", "lab.csv", "--out", "straight"]);
    assert_eq!(found["parameters"], straight["parameters"]);
}
