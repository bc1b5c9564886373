//! Folders that are moved, or copied elsewhere, go on there: no file of them holds an absolute path.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::campaigns::folder_with_plan;
use crate::common::change_sealed;
use crate::hostile_plans::ACCEPT;
use crate::{SMALL, digest, done, done_json};

/// All files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { paths.extend(files(&path)) } else { paths.push(path) }
    }
    paths
}

/// Refuses a folder of which a file holds the path of the folder above, which the test gave as an absolute one.
pub fn holds_no_path(folder: &Path, here: &Path) {
    let path = here.as_os_str().as_encoded_bytes();
    for file in files(folder) {
        let bytes = fs::read(&file).unwrap();
        assert!(
            !bytes.windows(path.len()).any(|part| part == path),
            "{} holds {}",
            file.display(),
            here.display()
        );
    }
}

pub fn copy(from: &Path, to: &Path) {
    for file in files(from) {
        let place = to.join(file.strip_prefix(from).unwrap());
        fs::create_dir_all(place.parent().unwrap()).unwrap();
        fs::copy(&file, place).unwrap();
    }
}

/// Starts a command and kills it, with the processes that it has started, as soon as a file is there.
pub fn killed_when(here: &Path, is_there: impl Fn() -> bool, arguments: &[&str]) {
    use std::os::unix::process::CommandExt;
    let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
    command.args(arguments).current_dir(here).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.process_group(0).spawn().unwrap();
    let since = Instant::now();
    while !is_there() {
        assert!(since.elapsed() < Duration::from_secs(300) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_micros(200));
    }
    assert!(
        Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).status().unwrap().success()
    );
    child.wait().unwrap();
}

fn small() -> String {
    SMALL.replace("count = 150", "count = 60")
}

/// A run from a sample goes on alone, wherever it is killed and whatever becomes of the sample.
#[test]
fn a_run_that_is_killed_at_its_first_file_goes_on_in_another_place() {
    let (base, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let here = base.path();
    fs::write(here.join("case.toml"), small()).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let whole = |folder: &str| here.join(folder).display().to_string();
    let command = |out: &str| ["shear", "case.toml", "--sample", "sample", "--out", out].map(String::from);
    let straight = command("straight");
    done(here, &straight.each_ref().map(String::as_str));
    let arguments = command(&whole("run"));
    killed_when(here, || here.join("run/run.json").is_file(), &arguments.each_ref().map(String::as_str));
    holds_no_path(&here.join("run"), here);
    let place = other.path().join("deep/er");
    fs::create_dir_all(&place).unwrap();
    copy(&here.join("run"), &place.join("run"));
    fs::rename(here.join("sample"), here.join("gone")).unwrap();
    done(&place, &["resume", "run"]);
    assert_eq!(digest(&place, "run"), digest(here, "straight"));
    // A process that is killed before there is a record leaves nothing that would be in the way.
    fs::create_dir(here.join("begun")).unwrap();
    fs::write(here.join("begun/.granum-lock"), "1\n").unwrap();
    fs::write(here.join("begun/checkpoint"), "unfinished").unwrap();
    fs::rename(here.join("gone"), here.join("sample")).unwrap();
    done(here, &command("begun").each_ref().map(String::as_str));
    assert_eq!(digest(here, "begun"), digest(here, "straight"));
}

/// A campaign that is killed as its tests begin goes on under another name, as a copy, and in a version that wrote absolute paths.
#[test]
fn a_campaign_that_is_killed_goes_on_in_another_place() {
    let base = folder_with_plan();
    let here = base.path();
    let plan = fs::read_to_string(here.join("plan.toml")).unwrap();
    fs::write(here.join("plan.toml"), plan.replacen("[design]", &format!("{ACCEPT}[design]"), 1)).unwrap();
    let out = here.join("study").display().to_string();
    let first = || {
        let folders = fs::read_dir(here.join("study/tests")).into_iter().flatten().flatten();
        folders.map(|entry| entry.path()).find(|path| path.join("run.json").is_file())
    };
    killed_when(here, || first().is_some(), &["campaign", "plan.toml", "--out", &out, "--workers", "2"]);
    let name = first().unwrap().file_name().unwrap().to_str().unwrap().to_string();
    holds_no_path(&here.join("study"), here);
    fs::create_dir(here.join("far")).unwrap();
    let at = |folder: &str| here.join(folder);
    copy(&at("study"), &at("far/copied"));
    copy(&at("study"), &at("old"));
    // As an earlier version left it, killed before the first checkpoint of a run, and with another sample in the old place.
    let sample = fs::read_dir(at("study/samples")).unwrap().next().unwrap().unwrap().file_name();
    let run = at("old/tests").join(&name);
    for file in ["checkpoint", "checkpoint.previous"] {
        let _ = fs::remove_file(run.join(file));
    }
    change_sealed(&run.join("run.json"), |record| {
        let sample = record["source"]["sample"].as_str().unwrap().rsplit('/').next().unwrap().to_string();
        let path = format!("/home/of-another/study/samples/{sample}");
        record["source"]["sample"] = path.into();
        record["status"] = "running".into();
    });
    fs::rename(at("study"), at("moved")).unwrap();
    assert!(!sample.is_empty());
    for folder in ["moved", "far/copied", "old"] {
        let summary = done_json(here, &["campaign", "plan.toml", "--out", folder]);
        assert_eq!(summary["failed"].as_array().map_or(0, Vec::len), 0, "{folder}: {summary}");
        holds_no_path(&at(folder), here);
    }
    done(here, &["campaign", "plan.toml", "--out", "straight"]);
    let sums = |folder: &str| fs::read(at(folder).join("dataset/SHA256SUMS")).unwrap();
    for folder in ["moved", "far/copied", "old"] {
        assert_eq!(sums(folder), sums("straight"), "{folder}");
    }
}

/// Several runs, and a training on them.
#[test]
fn a_queue_and_a_training_that_are_killed_go_on_in_another_place() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::create_dir(here.join("work")).unwrap();
    let work = here.join("work");
    fs::write(work.join("case.toml"), small()).unwrap();
    let out = work.join("runs").display().to_string();
    let several = [
        "shear",
        "case.toml",
        "--seed",
        "1,2",
        "--set",
        "shear.deviator_strain=0.01,0.02",
        "--out",
        out.as_str(),
    ];
    killed_when(&work, || work.join("runs/runs.json").is_file(), &several);
    holds_no_path(&work, here);
    fs::rename(&work, here.join("moved")).unwrap();
    let moved = here.join("moved");
    done(&moved, &["resume", "runs"]);
    holds_no_path(&moved, here);
    let whole = |name: &str| moved.join(name).display().to_string();
    let model = whole("model");
    let folders: Vec<String> = fs::read_dir(moved.join("runs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("run.json").is_file() && path.join("series.parquet").is_file())
        .map(|path| path.display().to_string())
        .collect();
    assert_eq!(folders.len(), 4, "{folders:?}");
    let mut train = vec!["train"];
    train.extend(folders.iter().map(String::as_str));
    train.extend([
        "-o",
        &model,
        "--input",
        "deviator_strain",
        "--output",
        "stress_ratio",
        "--method",
        "ridge",
    ]);
    done(&moved, &train);
    holds_no_path(&moved.join("model"), here);
}
