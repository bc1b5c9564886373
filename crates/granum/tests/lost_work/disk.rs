//! Behaviour with a full disk, folders that cannot be written, two processes and signals.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{json, run, stderr, stdout};
use crate::{CASE, assert_same, done};

/// Runs granum with a limit on the file size, in blocks of 512 bytes, which acts like a full disk: writing fails with an
/// error of the operating system.
fn with_full_disk(here: &Path, blocks: u32, arguments: &[&str]) -> Output {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_granum")])
        .args(arguments)
        .current_dir(here)
        .output()
        .unwrap()
}

/// Starts a command and ends it by a signal as soon as a given file exists.
fn interrupted(here: &Path, signal: &str, arguments: &[&str], wait_for: &str) -> Output {
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(arguments)
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !here.join(wait_for).exists() {
        assert!(started.elapsed() < Duration::from_secs(60), "no {wait_for}");
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[test]
fn a_full_disk_costs_nothing_that_was_there() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), CASE).unwrap();
    done(here, &["shear", "case.toml", "--out", "straight"]);

    // The disk is full from the start: the first checkpoint does not fit.
    let output = with_full_disk(here, 32, &["shear", "case.toml", "--out", "run"]);
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot write run/checkpoint: ") && told.contains("too large"), "{told}");
    let told = stdout(&run(here, &["status", "run"]));
    assert!(told.contains("failed") && told.contains("granum resume run"), "{told}");

    // The disk becomes full during the run: existing files remain unchanged.
    interrupted(here, "-TERM", &["shear", "case.toml", "--out", "later"], "later/checkpoint");
    let before = fs::read(here.join("later/checkpoint")).unwrap();
    let output = with_full_disk(here, 32, &["resume", "later", "--checkpoint-every", "0"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("cannot write later/checkpoint"), "{}", stderr(&output));
    assert!(fs::read(here.join("later/checkpoint")).unwrap() == before);

    // When there is space again, both runs can be resumed.
    for name in ["run", "later"] {
        done(here, &["resume", name]);
        assert_same(&here.join("straight"), &here.join(name));
    }
}

#[test]
fn a_full_disk_ends_a_training_that_goes_on_later() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let case = CASE
        .replace("deviator_strain = 0.05", "deviator_strain = 0.3")
        .replace("inertial_number = 3e-3", "inertial_number = 2e-2")
        .replace("solid_fraction = 0.52", "friction = 0.1\nsolid_fraction = \"none\"")
        .replace("states = 8", "states = 40");
    fs::write(here.join("case.toml"), case).unwrap();
    done(here, &["shear", "case.toml", "--out", "run"]);
    let train = |out: &'static str, seed: &'static str| {
        ["train", "run", "--trainer", "traingdx", "--epoch-factor", "1e-4", "--seed", seed, "--out", out]
    };
    // The networks of F1 have layers of 60 neurons, and their files are larger than the limit, whereas the plan of the training is
    // smaller.
    let output = with_full_disk(here, 20, &train("study", "1"));
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("too large") && told.contains(".json"), "{told}");
    let output = run(here, &train("study", "2"));
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("contains an unfinished training that differs in seed"), "{told}");
    let told = stdout(&run(here, &["status", "study"]));
    assert!(told.contains("training broken off") && told.contains("of 30 surrogates"), "{told}");
    done(here, &["resume", "study"]);
    assert!(stdout(&run(here, &["status", "study"])).contains("training finished, 30 of 30 surrogates"));
    assert!(stdout(&run(here, &["resume", "study"])).contains("the training is finished"));
    done(here, &train("other", "1"));
    assert_same(&here.join("study"), &here.join("other"));
}

#[test]
fn folders_that_cannot_be_written_are_told() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), CASE).unwrap();
    fs::write(here.join("file"), "mine").unwrap();
    for out in ["file", "file/run", "/dev/null/run"] {
        let output = run(here, &["shear", "case.toml", "--out", out]);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains("cannot create the folder") && told.contains(out), "{told}");
    }
    assert_eq!(fs::read_to_string(here.join("file")).unwrap(), "mine");
    // A file is in the place of the folder of snapshots.
    interrupted(here, "-INT", &["shear", "case.toml", "--out", "run"], "run/checkpoint");
    fs::write(here.join("run/snapshots"), "in the way").unwrap();
    let output = run(here, &["resume", "run"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("run/snapshots"), "{}", stderr(&output));
    fs::remove_file(here.join("run/snapshots")).unwrap();
    done(here, &["resume", "run"]);
}

#[test]
fn signals_end_a_preparation_in_good_order_and_a_second_process_is_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), CASE).unwrap();
    done(here, &["prepare", "case.toml", "--out", "straight"]);
    for (signal, name) in [("-TERM", "term"), ("-INT", "int")] {
        let wait_for = format!("{name}/checkpoint");
        let ended = interrupted(here, signal, &["prepare", "case.toml", "--out", name], &wait_for);
        let told = stderr(&ended);
        assert_eq!(ended.status.code(), Some(130), "{told}");
        assert!(told.contains(&format!("continue with `granum resume {name}`")), "{told}");
        let status = json(&stdout(&run(here, &["--json", "status", name])));
        assert_eq!(status["status"], "interrupted");
        assert!(status["phase"].as_str().unwrap().starts_with("compaction"), "{status}");
        for command in ["report", "digest"] {
            let output = run(here, &[command, name]);
            assert!(command == "digest" || output.status.code() == Some(1), "{}", stderr(&output));
        }
        done(here, &["resume", name]);
        assert_same(&here.join("straight"), &here.join(name));
        let status = json(&stdout(&run(here, &["--json", "status", name])));
        assert_eq!((&status["status"], &status["phase"]), (&"finished".into(), &"".into()));
    }
    let mut child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(["shear", "case.toml", "--out", "busy"])
        .current_dir(here)
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !here.join("busy/checkpoint").exists() {
        assert!(started.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(1));
    }
    for arguments in [&["resume", "busy"][..], &["shear", "case.toml", "--out", "busy", "--force"]] {
        let output = run(here, arguments);
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains("busy is in use by another granum process"), "{}", stderr(&output));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // The run was interrupted before its test, and the message states how to continue.
    let output = run(here, &["report", "busy"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("continue it with `granum resume busy`"), "{}", stderr(&output));
    done(here, &["resume", "busy"]);
}
