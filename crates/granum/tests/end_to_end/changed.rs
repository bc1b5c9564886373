//! Files that were changed, exchanged or removed are noticed by every command that reads them, and `--force` replaces only what
//! granum wrote.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{change_sealed, json, run, stderr, stdout};
use crate::networks::make_run;
use crate::{SMALL, digest, done, done_json, refused};

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let copied = to.join(path.file_name().unwrap());
        if path.is_dir() { copy(&path, &copied) } else { fs::copy(&path, &copied).map(drop).unwrap() }
    }
}

#[test]
fn the_series_of_another_run_is_refused_by_every_command() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    make_run(here, 1);
    make_run(here, 2);
    done(here, &["train", "run-1", "--trainer", "traingdx", "--epoch-factor", "2e-4", "--out", "study"]);
    fs::write(here.join("lab.csv"), "axial_strain (%),deviator_stress (kPa)\n0,0\n1,10\n2,12\n").unwrap();
    let series = here.join("run-2/series.parquet");
    let good = fs::read(&series).unwrap();
    fs::copy(here.join("run-1/series.parquet"), &series).unwrap();
    let readers = [
        &["status", "run-2"][..],
        &["digest", "run-2"],
        &["report", "run-2"],
        &["export", "run-2", "-o", "series.csv"],
        &["export", "run-2", "-o", "grains.vtp"],
        &["export", "run-2", "--to", "lammps", "-o", "deck"],
        &["compare", "run-2", "lab.csv"],
        &["table", "run-2", "-o", "table.csv"],
        &["train", "run-1", "--unseen", "run-2", "--out", "other"],
        &["train", "run-2", "--out", "other"],
        &["evaluate", "study", "run-2"],
        &["measure", "run-2"],
        &["measure", "run-2/snapshots/end.json"],
        &["stiffness", "run-2"],
        &["shear", "case.toml", "--sample", "run-2", "--out", "sheared"],
    ];
    for (word, is_removed) in [("SHA-256", false), ("is missing", true)] {
        if is_removed {
            fs::remove_file(&series).unwrap();
        }
        for command in readers {
            let told = refused(here, 1, command);
            assert!(told.contains("series.parquet") && told.contains(word), "{command:?}: {told}");
            for name in ["series.csv", "grains.vtp", "deck", "other", "compare.svg", "table.csv", "sheared"] {
                assert!(!here.join(name).exists(), "{command:?} left {name}");
            }
        }
    }
    // The checkpoint has all states: the table is written again, to the same bytes.
    let output = run(here, &["resume", "run-2"]);
    assert!(output.status.success() && stderr(&output).contains("writes it again"), "{}", stderr(&output));
    assert!(fs::read(&series).unwrap() == good);
    done(here, &["status", "run-2"]);

    // A network of another study, or of this one under another name.
    fs::copy(here.join("study/F3-antony2006.json"), here.join("study/F1-antony2006.json")).unwrap();
    for command in [
        &["status", "study"][..],
        &["evaluate", "study", "run-1"],
        &["predict", "study", "-m", "F4", "-s", "force=1"],
        &["resume", "study"],
    ] {
        let told = refused(here, 1, command);
        assert!(told.contains("F1-antony2006.json") && told.contains("SHA-256"), "{command:?}: {told}");
    }
    // The checkpoint of another run.
    for name in ["checkpoint", "checkpoint.previous"] {
        fs::copy(here.join("run-1").join(name), here.join("run-2").join(name)).unwrap();
    }
    for command in ["stiffness", "resume"] {
        let told = refused(here, 1, &[command, "run-2"]);
        assert!(told.contains("belongs to a run of another case"), "{told}");
    }
}

#[test]
fn changed_bits_are_named_and_a_run_goes_on_only_if_it_can_write_them_again() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["shear", "case.toml", "--out", "run"]);
    let whole = digest(here, "run");
    for name in
        ["snapshots/start.grains.parquet", "snapshots/end.json", "forces.parquet", "case.toml", "run.json"]
    {
        let path = here.join("run").join(name);
        let good = fs::read(&path).unwrap();
        let mut bytes = good.clone();
        // In the case a digit of a number, elsewhere any bit.
        let middle = bytes.len() / 2;
        let at = match name {
            "case.toml" => String::from_utf8_lossy(&good).find("count = 1").unwrap() + 8,
            _ => middle,
        };
        bytes[at] ^= 1;
        fs::write(&path, &bytes).unwrap();
        for command in ["status", "digest"] {
            let output = run(here, &["--json", command, "run"]);
            assert_eq!(output.status.code(), Some(1), "{command} {name}");
            assert!(stderr(&output).contains(name), "{command} {name}: {}", stderr(&output));
            if command == "status" && !name.ends_with("toml") && name != "run.json" {
                let told = json(&stdout(&output));
                assert!(told["faults"][0].as_str().unwrap().contains(name), "{told}");
            }
        }
        let before = fs::read(&path).unwrap();
        let output = run(here, &["resume", "run"]);
        if ["snapshots/end.json", "forces.parquet"].contains(&name) {
            assert!(output.status.success(), "{}", stderr(&output));
            assert!(fs::read(&path).unwrap() == good, "{name}");
        } else {
            assert_eq!(output.status.code(), Some(1), "{name}: {}", stderr(&output));
            assert!(stderr(&output).contains(name), "{}", stderr(&output));
            assert!(fs::read(&path).unwrap() == before);
            fs::write(&path, &good).unwrap();
        }
        assert_eq!(digest(here, "run"), whole);
    }
    // An earlier version left no SHA-256 of snapshots: this is said once, and the data are read.
    change_sealed(&here.join("run/run.json"), |record| {
        record["format"] = 1.into();
        record["content"].as_object_mut().unwrap().retain(|name, _| !name.starts_with("snapshots"));
    });
    let output = run(here, &["export", "run", "-o", "end.vtp"]);
    assert!(output.status.success());
    assert_eq!(stderr(&output).matches("cannot be checked").count(), 1, "{}", stderr(&output));
    assert_eq!(digest(here, "run"), whole);
}

#[test]
fn snapshots_that_are_removed_during_a_run_are_noticed() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL.replace("deviator_strain = 0.02", "deviator_strain = 0.05"))
        .unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(["shear", "case.toml", "--out", "run"])
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !here.join("run/snapshots/start.json").exists() {
        assert!(started.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    fs::remove_dir_all(here.join("run/snapshots")).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("was removed while the run was under way"), "{}", stderr(&output));
    let told = refused(here, 1, &["resume", "run"]);
    assert!(told.contains("snapshots/start") && told.contains("is missing"), "{told}");
}

#[test]
fn force_replaces_a_run_of_its_kind_and_keeps_what_is_the_users() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    done(here, &["shear", "case.toml", "--sample", "sample", "--out", "run"]);
    done(here, &["report", "run"]);
    for name in ["snapshots/my.json", "figures/mine.svg", "notes.txt"] {
        fs::write(here.join("run").join(name), "mine").unwrap();
    }
    let whole = digest(here, "run");
    let told = refused(here, 1, &["prepare", "case.toml", "--out", "run", "--force"]);
    assert!(told.contains("a finished test") && !told.contains("give --force"), "{told}");
    refused(here, 1, &["shear", "case.toml", "--out", "sample", "--force"]);
    assert_eq!(digest(here, "run"), whole);
    // A folder that was copied without its hidden files can be continued and replaced.
    copy(&here.join("run"), &here.join("copied"));
    fs::remove_file(here.join("copied/.granum-lock")).unwrap();
    assert!(done(here, &["resume", "copied"]).contains("already finished"));
    fs::remove_file(here.join("copied/.granum-lock")).unwrap();
    for name in ["run", "copied"] {
        done(here, &["shear", "case.toml", "--sample", "sample", "--out", name, "--force"]);
        assert_eq!(digest(here, name), whole);
        for kept in ["snapshots/my.json", "figures/mine.svg", "notes.txt"] {
            assert_eq!(fs::read(here.join(name).join(kept)).unwrap(), b"mine", "{name}/{kept}");
        }
        assert!(!here.join(name).join("report.html").exists());
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("run", here.join("link")).unwrap();
        for out in ["link", "link/"] {
            let told =
                refused(here, 1, &["shear", "case.toml", "--sample", "sample", "--out", out, "--force"]);
            assert!(told.contains("is a symbolic link"), "{told}");
        }
        assert_eq!(digest(here, "run"), whole);
    }
    // What a killed process left of an output file, or of a figure, goes with the next one.
    let left = [
        ".series.csv.4711-0.granum-unfinished",
        "run/figures/.figure-s1-stress.svg.4711-2.granum-unfinished",
    ];
    for name in left {
        fs::create_dir_all(here.join(name).parent().unwrap()).unwrap();
        fs::write(here.join(name), "half").unwrap();
    }
    done(here, &["export", "run", "-o", "series.csv"]);
    done(here, &["report", "run"]);
    for name in left {
        assert!(!here.join(name).exists(), "{name}");
    }
}

#[test]
fn of_twenty_starts_at_once_one_wins_and_the_others_say_who() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let start = |force: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
        command.args(["shear", "case.toml", "--sample", "sample", "--out", "run", "--threads", "1"]);
        command.args(force.then_some("--force"));
        command.current_dir(here).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let children: Vec<_> = (0..20).map(|_| start(false)).collect();
    let ids: Vec<u32> = children.iter().map(std::process::Child::id).collect();
    let outputs: Vec<_> = children.into_iter().map(|child| child.wait_with_output().unwrap()).collect();
    let winners: Vec<usize> = (0..20).filter(|&k| outputs[k].status.success()).collect();
    assert_eq!(winners.len(), 1, "{winners:?}");
    let who = format!("run is in use by another granum process (process {})", ids[winners[0]]);
    for (k, output) in outputs.iter().enumerate().filter(|(k, _)| *k != winners[0]) {
        let told = stderr(output);
        let finished =
            told.contains("run already contains a finished test") || told.contains("run exists already");
        assert!(output.status.code() == Some(1) && (told.contains(&who) || finished), "{k}: {told}");
    }
    assert_eq!(done_json(here, &["status", "run"])["status"], "finished");
    // With --force one of them has the folder at a time, and the run is whole at the end.
    let whole = digest(here, "run");
    let outputs = (0..4).map(|_| start(true)).collect::<Vec<_>>().into_iter();
    let outputs: Vec<_> = outputs.map(|child| child.wait_with_output().unwrap()).collect();
    assert!(outputs.iter().any(|output| output.status.success()));
    for output in outputs.iter().filter(|output| !output.status.success()) {
        assert!(stderr(output).contains("is in use by another granum process"), "{}", stderr(output));
    }
    assert_eq!(digest(here, "run"), whole);
}
