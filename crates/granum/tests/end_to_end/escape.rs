//! No command creates, changes or removes anything outside its output folder, whatever the files of the folder contain and
//! wherever links in it point.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use granum_antony2006::PaperSummary;
use granum_antony2006::reproduction::{Reproduction, ReproductionOptions};
use granum_antony2006::summary::RunSummary;
use serde_json::json;

use crate::common::{change_sealed as change, run, stderr};
use crate::networks::make_run;
use crate::{SMALL, done};

/// Names that lead out of a folder; the first is an absolute path in the neighbouring folder.
fn hostile(place: &Place) -> [String; 5] {
    let absolute = place.base.path().join("outside/x").display().to_string();
    [absolute, "../outside/x".into(), "a/../../outside/x".into(), "..".into(), "x\0y".into()]
}

/// A working folder, and a neighbouring folder that must not be changed.
struct Place {
    base: tempfile::TempDir,
    before: BTreeMap<PathBuf, Vec<u8>>,
}

/// All files outside the working folder with their contents; links are not followed.
fn outside(base: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![base.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            let (path, kind) = (entry.path(), entry.file_type().unwrap());
            if path == base.join("work") {
                continue;
            }
            let bytes = if kind.is_file() { fs::read(&path).unwrap() } else { Vec::new() };
            found.insert(path.clone(), bytes);
            if kind.is_dir() {
                folders.push(path);
            }
        }
    }
    found
}

impl Place {
    fn new() -> Place {
        let base = tempfile::tempdir().unwrap();
        for folder in ["work", "outside/snapshots", "outside/figures"] {
            fs::create_dir_all(base.path().join(folder)).unwrap();
        }
        for file in ["thesis", "F1-1.json", "snapshots/end.json", "figures/figure-s1-stress.svg", "x.json"] {
            fs::write(base.path().join("outside").join(file), "mine").unwrap();
        }
        let mut place = Place { base, before: BTreeMap::new() };
        place.before = outside(place.base.path());
        place
    }

    fn work(&self) -> PathBuf {
        self.base.path().join("work")
    }

    /// Runs a command, which may fail but must neither panic nor change anything outside; returns its standard error.
    fn harmless(&self, arguments: &[&str]) -> String {
        let output = run(&self.work(), arguments);
        let told = stderr(&output);
        assert!(matches!(output.status.code(), Some(0..=2)), "granum {}: {told}", arguments.join(" "));
        assert!(!told.contains("panicked"), "{told}");
        let after = outside(self.base.path());
        assert!(after == self.before, "granum {}: touched what is outside: {told}", arguments.join(" "));
        told
    }

    /// As [`Place::harmless`], for a command that must be refused with these words.
    fn refused(&self, words: &str, arguments: &[&str]) {
        let told = self.harmless(arguments);
        // The message is wrapped into lines.
        let flat = told.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(flat.contains(words), "granum {}: {told}", arguments.join(" "));
    }
}

#[test]
fn names_in_studies_lead_nowhere() {
    let place = Place::new();
    let work = place.work();
    make_run(&work, 1);
    let train = ["train", "run-1", "--out", "study", "--trainer", "traingdx", "--epoch-factor", "2e-4"];
    done(&work, &train);
    let (study, plan) = (work.join("study/study.json"), work.join("study/training.json"));
    let (good_study, good_plan) = (fs::read(&study).unwrap(), fs::read(&plan).unwrap());
    for name in hostile(&place) {
        change(&study, |file| file["files"][format!("{name}.json")] = json!("ab"));
        let words = "cannot be part of a file name";
        place.refused(words, &["evaluate", "study", "run-1"]);
        place.refused(words, &["predict", "study", "-m", name.split('\0').next().unwrap(), "-s", "x=1"]);
        place.harmless(&["report", "study"]);
        fs::write(&study, &good_study).unwrap();

        change(&plan, |file| file["definition"]["methods"][0] = json!(name));
        place.refused(words, &["status", "study"]);
        fs::remove_file(&study).unwrap();
        place.refused(words, &["resume", "study"]);
        place.refused(words, &train);
        fs::write(&plan, &good_plan).unwrap();
        fs::write(&study, &good_study).unwrap();
    }
    // Each file that is written under a fixed name is replaced by a link.
    fs::remove_file(&study).unwrap();
    for name in
        ["F1-ridge.json", "F1-antony2006-1.json", "F1-antony2006-1.unfinished", "seconds.json", "study.json"]
    {
        let _ = fs::remove_file(work.join("study").join(name));
        symlink("../../outside/F1-1.json", work.join("study").join(name)).unwrap();
    }
    place.harmless(&["resume", "study"]);
    place.harmless(&[&train[..], &["--force"]].concat());
}

#[test]
fn records_and_links_of_runs_lead_nowhere() {
    let place = Place::new();
    let work = place.work();
    fs::write(work.join("case.toml"), SMALL).unwrap();
    done(&work, &["shear", "case.toml", "--out", "run"]);
    let (folder, record) = (work.join("run"), work.join("run/run.json"));
    let (good, checkpoint) = (fs::read(&record).unwrap(), fs::read(folder.join("checkpoint")).unwrap());
    for name in hostile(&place) {
        let source = json!({ "sample": name });
        let packing = json!({ "packing": { "file": name, "sha256": "00" } });
        for source in [source, packing] {
            change(&record, |file| {
                file["source"] = source;
                file["status"] = json!("running");
                file["phase"] = json!(name);
                file["content"] = json!({ name.as_str(): "00" });
                file["steps"] = json!({ name.as_str(): 3 });
            });
            place.harmless(&["status", "run"]);
            place.harmless(&["resume", "run"]);
            place.harmless(&["report", "run", "--force"]);
            // Without a checkpoint the run starts again from its source, which does not exist.
            for name in ["checkpoint", "checkpoint.previous"] {
                let _ = fs::remove_file(folder.join(name));
            }
            change(&record, |file| file["status"] = json!("running"));
            place.harmless(&["resume", "run"]);
            fs::write(&record, &good).unwrap();
            fs::write(folder.join("checkpoint"), &checkpoint).unwrap();
        }
    }
    let running = || change(&record, |file| file["status"] = json!("running"));
    running();
    for (name, command) in [
        ("snapshots", &["resume", "run"][..]),
        ("figures", &["report", "run", "--force"]),
        ("snapshots", &["shear", "case.toml", "--out", "run", "--force"]),
    ] {
        let _ = fs::rename(folder.join(name), folder.join("kept"));
        symlink(format!("../../outside/{name}"), folder.join(name)).unwrap();
        place.refused("is a symbolic link", command);
        place.harmless(&["status", "run"]);
        fs::remove_file(folder.join(name)).unwrap();
        let _ = fs::rename(folder.join("kept"), folder.join(name));
    }
    for name in ["series.parquet", "forces.parquet", "report.html", "checkpoint.refused"] {
        let _ = fs::remove_file(folder.join(name));
        symlink("../../outside/thesis", folder.join(name)).unwrap();
    }
    place.harmless(&["resume", "run"]);
    place.harmless(&["report", "run", "--force"]);
    fs::remove_file(folder.join(".granum-lock")).unwrap();
    symlink("../../outside/thesis", folder.join(".granum-lock")).unwrap();
    place.harmless(&["status", "run"]);
    place.refused("is not a folder that granum wrote", &["resume", "run"]);
    place.refused(
        "contains files that granum did not write",
        &["shear", "case.toml", "--out", "run", "--force"],
    );
}

#[test]
fn reproductions_lead_nowhere() {
    let place = Place::new();
    let work = place.work();
    fs::write(work.join("case.toml"), SMALL).unwrap();
    done(&work, &["shear", "case.toml", "--out", "study"]);
    for name in fs::read_dir(work.join("study")).unwrap().map(|entry| entry.unwrap().path()) {
        if name.file_name().unwrap() != ".granum-lock" {
            if name.is_dir() { fs::remove_dir_all(name).unwrap() } else { fs::remove_file(name).unwrap() }
        }
    }
    // The folder of a reproduction whose runs are in another place.
    let options = ReproductionOptions { quick: true, ..ReproductionOptions::default() };
    let of = Reproduction::new(options, vec!["training-11".into()]);
    of.write(&work.join("study")).unwrap();
    symlink("../../outside", work.join("study/runs")).unwrap();
    place.refused("runs: is a symbolic link", &["reproduce", "--quick", "--out", "study"]);
    fs::remove_file(work.join("study/runs")).unwrap();
    fs::create_dir_all(work.join("study/runs")).unwrap();
    fs::create_dir_all(work.join("study/models")).unwrap();
    symlink("../../../outside", work.join("study/runs/training-11")).unwrap();
    place.refused("training-11: is a symbolic link", &["reproduce", "--quick", "--out", "study"]);
    place.harmless(&["status", "study"]);
    for name in hostile(&place) {
        let mut summary = PaperSummary::default();
        summary.dem.runs.push(RunSummary { role: name, ..RunSummary::default() });
        fs::write(work.join("study/summary.json"), serde_json::to_vec(&summary).unwrap()).unwrap();
        place.harmless(&["status", "study"]);
        place.refused("is neither training nor unseen", &["report", "study", "--force"]);
    }
    // Hostile names in the description of the reproduction have no effect either.
    let file = work.join("study/reproduction.json");
    for name in hostile(&place) {
        of.write(&work.join("study")).unwrap();
        change(&file, |file| file["options"]["trainer"] = json!(name));
        place.refused(
            "already contains an unfinished reproduction",
            &["reproduce", "--quick", "--out", "study"],
        );
        place.harmless(&["resume", "study"]);
        change(&file, |file| file["runs"][0] = json!(name));
        for command in
            [&["status", "study"][..], &["resume", "study"], &["reproduce", "--force", "--out", "study"]]
        {
            place.refused("cannot be part of a file name", command);
        }
    }
}
