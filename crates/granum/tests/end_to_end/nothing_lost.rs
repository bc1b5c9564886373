//! Without `--force` no command changes or removes an existing file, whatever kind of folder it is given, and every refusal
//! names the command line that continues from the existing files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use granum_antony2006::reproduction::{Reproduction, ReproductionOptions};
use serde_json::json;

use crate::common::{change_sealed, run, stderr};
use crate::networks::make_run;
use crate::{SMALL, done, done_json, refused};

/// All files under a folder with their contents, except locks.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.file_name().unwrap() != ".granum-lock" {
            found.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    found
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let copied = to.join(path.file_name().unwrap());
        if path.is_dir() { copy(&path, &copied) } else { fs::copy(&path, &copied).map(drop).unwrap() }
    }
}

fn set_status(run: &Path, status: &str) {
    change_sealed(&run.join("run.json"), |record| record["status"] = json!(status));
}

/// The folder of a reproduction with small runs in place of the real ones, which would take too long.
fn reproduction(here: &Path, name: &str, quick: bool, trainer: &str, finished: bool) {
    let folder = here.join(name);
    let names = ["training-11", "unseen-12", "unseen-13"].map(String::from).to_vec();
    for run in &names {
        copy(&here.join("run"), &folder.join("runs").join(run));
    }
    copy(&here.join("study"), &folder.join("models"));
    fs::copy(here.join("study/.granum-lock"), folder.join(".granum-lock")).unwrap();
    let options = ReproductionOptions { quick, trainer: trainer.into(), ..Default::default() };
    Reproduction::new(options, names).write(&folder).unwrap();
    if finished {
        let summary = serde_json::to_vec(&granum_antony2006::PaperSummary::default()).unwrap();
        fs::write(folder.join("summary.json"), summary).unwrap();
        fs::write(folder.join("report.html"), "a report").unwrap();
    } else {
        set_status(&folder.join("runs/unseen-13"), "interrupted");
    }
}

/// A folder of each kind, with the words that every refusal must contain; they are made once for all tests.
fn folders(here: &Path) -> &'static [(&'static str, &'static str)] {
    static MADE: OnceLock<Vec<(&'static str, &'static str)>> = OnceLock::new();
    let from = Path::new(env!("CARGO_TARGET_TMPDIR")).join("folders-of-each-kind");
    let words = MADE.get_or_init(|| {
        if from.exists() {
            fs::remove_dir_all(&from).unwrap();
        }
        fs::create_dir_all(&from).unwrap();
        make_folders(&from)
    });
    copy(&from, here);
    words
}

fn make_folders(here: &Path) -> Vec<(&'static str, &'static str)> {
    fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    done(here, &["shear", "case.toml", "--sample", "sample", "--out", "run"]);
    copy(&here.join("run"), &here.join("drawn"));
    done(here, &["report", "drawn"]);
    copy(&here.join("run"), &here.join("broken run"));
    set_status(&here.join("broken run"), "interrupted");
    copy(&here.join("sample"), &here.join("half-made"));
    set_status(&here.join("half-made"), "running");
    make_run(here, 1);
    done(here, &["train", "run-1", "--trainer", "traingdx", "--epoch-factor", "2e-4", "--out", "study"]);
    copy(&here.join("study"), &here.join("half-trained"));
    for file in ["study.json", "F3-antony2006.json"] {
        fs::remove_file(here.join("half-trained").join(file)).unwrap();
    }
    let usual = "levenberg-marquardt";
    reproduction(here, "full", false, usual, true);
    reproduction(here, "my quick", true, usual, true);
    reproduction(here, "quick-half", true, usual, false);
    reproduction(here, "paper", false, "traingdx", true);
    fs::create_dir(here.join("thesis")).unwrap();
    for file in ["case.toml", "chapter.tex", "rows.csv", "packing.csv"] {
        fs::write(here.join("thesis").join(file), "mine").unwrap();
    }
    vec![
        ("sample", "`granum run CASE --sample sample`"),
        ("run", "`granum report run`"),
        ("drawn", "`granum report drawn --force`"),
        ("broken run", "`granum resume 'broken run'`"),
        ("half-made", "`granum resume half-made`"),
        ("study", "`granum evaluate study RUN...`"),
        ("half-trained", "`granum resume half-trained`"),
        ("full", "`granum reproduce --out full`"),
        ("my quick", "`granum reproduce --quick --out 'my quick'`"),
        ("quick-half", "`granum reproduce --quick --out quick-half`"),
        ("paper", "`granum reproduce --trainer traingdx --out paper`"),
        ("thesis", "contains files that granum did not write"),
    ]
}

/// Runs a command, after which all existing files must be unchanged; returns its standard error if it was refused.
fn keeps(here: &Path, before: &BTreeMap<PathBuf, Vec<u8>>, arguments: &[&str]) -> Option<String> {
    let output = run(here, arguments);
    let told = stderr(&output);
    let line = format!("granum {}", arguments.join(" "));
    assert!(matches!(output.status.code(), Some(0..=2)) && !told.contains("panicked"), "{line}: {told}");
    let after = files(here);
    for (path, bytes) in before {
        assert!(after.get(path) == Some(bytes), "{line} changed {}: {told}", path.display());
    }
    // Files that a report adds are removed, so that every command finds the same folder.
    for path in after.keys().filter(|path| !before.contains_key(*path)) {
        assert!(output.status.success(), "{line} failed and left {}: {told}", path.display());
        fs::remove_file(path).unwrap();
    }
    (!output.status.success()).then_some(told)
}

#[test]
fn without_force_no_command_changes_what_is_there() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let folders = folders(here);
    let packing = "grains.csv";
    done(here, &["export", "sample", "-o", packing]);
    fs::write(here.join("path.csv"), "normal_approach,tangential_displacement\n1e-8,0\n").unwrap();
    let before = files(here);
    for (folder, words) in folders {
        let out = ["--out", folder];
        for command in [
            &["shear", "case.toml"][..],
            &["shear", "case.toml", "--sample", "sample"],
            &["shear", "case.toml", "--packing", packing],
            &["prepare", "case.toml"],
            &["prepare", "case.toml", "--packing", packing],
            &["train", "run-1", "--seed", "5"],
            &["reproduce", "--quick", "--trainer", "traingdx"],
        ] {
            let told = keeps(here, &before, &[command, &out].concat());
            let told =
                told.unwrap_or_else(|| panic!("granum {} --out {folder} was taken", command.join(" ")));
            assert!(told.contains(words), "granum {} --out {folder}: {told}", command.join(" "));
        }
        // The same options could continue the reproduction, but here the runs are of another case and must not be lost.
        for command in [&["reproduce"][..], &["reproduce", "--quick"]] {
            let told = keeps(here, &before, &[command, &out].concat()).unwrap();
            assert!(told.contains(words) || told.contains("its run has another case"), "{folder}: {told}");
        }
        let file = |name: &str| format!("{folder}/{name}");
        let (case, rows, series) = (file("case.toml"), file("rows.csv"), file("series.parquet"));
        for command in [
            &["init", folder][..],
            &["init", &case],
            &["report", folder],
            &["report", "run-1", "--out", folder],
            &["report", "run-1", "--out", &file("report.html")],
            &["status", folder],
            &["digest", folder],
            &["evaluate", folder, "run-1"],
            &["forces", packing, "-o", &rows],
            &["forces", packing, "-o", &series],
            &["pair", "path.csv", "-o", &rows],
            &["impact", "--speed", "0.1", "-o", &rows],
            &["predict", "study", "-m", "F1", "-i", "path.csv", "-o", &rows],
        ] {
            keeps(here, &before, command);
        }
        if !["broken run", "half-made", "half-trained"].contains(folder) {
            keeps(here, &before, &["resume", folder]);
        }
    }
}

#[test]
fn force_replaces_only_what_is_of_the_same_kind() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let folders = folders(here);
    let before = files(here);
    for (folder, _) in folders {
        let kind = match *folder {
            "study" | "half-trained" => "train",
            "full" | "my quick" | "quick-half" | "paper" => "reproduce",
            "thesis" => "none",
            _ => "shear",
        };
        for command in [&["shear", "case.toml"][..], &["train", "run-1"], &["reproduce"]] {
            if command[0] != kind {
                let told = keeps(here, &before, &[command, &["--force", "--out", folder]].concat());
                assert!(told.is_some(), "granum {} --force --out {folder} was taken", command.join(" "));
            }
        }
    }
}

/// Starts a command and kills it; returns false if it ended before that.
fn killed_after(here: &Path, milliseconds: u64, arguments: &[&str]) -> bool {
    let mut child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(arguments)
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(milliseconds));
    let _ = child.kill();
    child.wait().unwrap().code().is_none()
}

#[test]
fn a_forced_reproduction_that_is_killed_goes_on_without_force() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    folders(here);
    assert!(killed_after(here, 2000, &["reproduce", "--quick", "--force", "--out", "full"]));
    assert!(!here.join("full/summary.json").exists() && !here.join("full/models/study.json").exists());
    assert_eq!(done_json(here, &["status", "full"])["command"], "granum reproduce --quick --out full");
    for command in [&["resume", "full"][..], &["reproduce", "--quick", "--out", "full"]] {
        assert!(killed_after(here, 1000, command), "granum {} was refused", command.join(" "));
    }
}

#[test]
fn status_tells_the_exact_command_and_is_done_only_when_all_is() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    folders(here);
    let next = |folder: &str| {
        let status = done_json(here, &["status", folder]);
        (status["next"].as_str().unwrap().to_string(), status["command"].clone())
    };
    let (text, command) = next("quick-half");
    assert_eq!(command, "granum reproduce --quick --out quick-half");
    assert_eq!(text, "continue it: granum reproduce --quick --out quick-half");
    assert!(next("my quick").0.starts_with("done; see my quick"), "{}", next("my quick").0);
    set_status(&here.join("my quick/runs/unseen-12"), "interrupted");
    assert_eq!(next("my quick").0, "continue it: granum reproduce --quick --out 'my quick'");
    assert!(!done(here, &["status", "my quick"]).contains("done"));
    fs::remove_dir_all(here.join("full/runs/unseen-12")).unwrap();
    assert_eq!(next("full").0, "continue it: granum reproduce --out full");
    let told = done(here, &["status", "full"]);
    assert!(told.contains("full/runs/unseen-12: not begun"), "{told}");
    fs::create_dir(here.join("full/runs/unseen-12")).unwrap();
    assert_eq!(done_json(here, &["status", "full"])["runs"][1]["status"], "not begun");
    // A reproduction of another version is refused, and the message gives the command of that version.
    let path = here.join("paper/reproduction.json");
    change_sealed(&path, |file| file["granum_version"] = json!("0.0.9"));
    let told = refused(here, 1, &["reproduce", "--trainer", "traingdx", "--out", "paper"]);
    assert!(told.contains("the version of granum (0.0.9, not 0.1.0)"), "{told}");
    assert!(next("paper").0.contains("done; see"), "{}", next("paper").0);
    set_status(&here.join("paper/runs/unseen-12"), "interrupted");
    let text = next("paper").0;
    assert!(text.contains("started by granum 0.0.9") && text.ends_with("--out paper"), "{text}");
    // Without this file the options of the reproduction are unknown.
    fs::remove_file(&path).unwrap();
    let told = refused(here, 1, &["reproduce", "--out", "paper"]);
    assert!(told.contains("whose options are not recorded"), "{told}");
    let told = refused(here, 1, &["resume", "paper"]);
    assert!(told.contains("there is no reproduction.json with its options"), "{told}");
}

#[test]
fn mistakes_leave_nothing_behind_and_cost_nothing_with_force() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL).unwrap();
    fs::write(here.join("bad.csv"), "id,x,y\n1,2,3\n").unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    fs::write(here.join("other.toml"), SMALL.replace("count = 150", "count = 160")).unwrap();
    done(here, &["shear", "case.toml", "--sample", "sample", "--out", "good"]);
    let before = files(here);
    for command in [
        &["shear", "case.toml", "--sample", "smaple"][..],
        &["shear", "case.toml", "--packing", "nothing.csv"],
        &["shear", "case.toml", "--packing", "bad.csv"],
        &["shear", "other.toml", "--sample", "sample"],
        &["shear", "case.toml", "--sample", "good"],
        &["prepare", "case.toml", "--packing", "nothing.csv"],
        &["prepare", "case.toml", "--packing", "bad.csv"],
        &["shear", "case.toml", "--isa", "mmx"],
        &["shear", "case.toml", "--checkpoint-every", "-1"],
        &["reproduce", "--quick", "--trainer", "adem"],
        &["reproduce", "--quick", "--threads", "0"],
        &["reproduce", "--quick", "--checkpoint-every", "-1"],
        &["train", "sample"],
        // A record with five states is too short for the sub-models.
        &["train", "good"],
        &["train", "good", "--threads", "0"],
    ] {
        keeps(here, &before, &[command, &["--out", "new"]].concat()).expect("a mistake");
        assert!(!here.join("new").exists(), "granum {}", command.join(" "));
        keeps(here, &before, &[command, &["--out", "good", "--force"]].concat()).expect("a mistake");
    }
    done(here, &["shear", "case.toml", "--sample", "sample", "--out", "new"]);
}

#[test]
fn a_training_that_fails_leaves_its_folder_to_the_corrected_command() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    make_run(here, 1);
    let train = |run: &'static str, more: &[&'static str]| {
        [&["train", run, "--trainer", "traingdx", "--epoch-factor", "2e-4", "--out", "study"], more].concat()
    };
    // This record has too few states for a sub-model.
    fs::write(
        here.join("short.toml"),
        fs::read_to_string(here.join("case.toml")).unwrap().replace("states = 40", "states = 5"),
    )
    .unwrap();
    done(here, &["shear", "short.toml", "--out", "short"]);
    let told = refused(here, 1, &train("short", &[]));
    assert!(told.contains("training states"), "{told}");
    assert!(!here.join("study").exists());
    done(here, &train("run-1", &[]));
    let before = files(here);
    keeps(here, &before, &train("short", &["--force"])).expect("too few states");
}

#[test]
fn what_is_finished_is_told_so_and_a_mistake_is_told_once() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL).unwrap();
    assert!(done(here, &["shear", "case.toml", "--out", "run"]).contains("wrote run"));
    let told = done(here, &["resume", "run"]);
    assert!(told.contains("it was already finished") && !told.contains("wrote"), "{told}");
    assert_eq!(done_json(here, &["resume", "run"])["status"], "finished");

    fs::write(here.join("bad.toml"), "[grains]\ncount = -5\n").unwrap();
    let told = refused(here, 1, &["shear", "bad.toml", "--out", "bad"]);
    assert_eq!(told.matches("bad.toml:2:").count(), 1, "{told}");
    assert_eq!(told.lines().count(), 1, "{told}");
}
