//! A command whose messages or output cannot be written, and whose terminal goes away.

use std::fs::{self, OpenOptions};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{json, run, stderr, stdout};
use crate::{CASE, assert_same, done};

/// The case without the search for a friction, which takes a second.
fn short() -> String {
    CASE.replace("solid_fraction = 0.6", "friction = 0.1\nsolid_fraction = \"none\"")
}

fn granum(here: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
    command.args(arguments).current_dir(here);
    command
}

/// A device to which nothing can be written.
fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").unwrap().into()
}

/// Runs a command whose standard output or error is a pipe that nobody reads, as after `| head -1`.
fn with_closed_pipe(mut command: Command, error: bool) -> Output {
    if error {
        command.stderr(Stdio::piped()).stdout(Stdio::piped());
    } else {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
    }
    let mut child = command.spawn().unwrap();
    if error {
        drop(child.stderr.take());
    } else {
        drop(child.stdout.take());
    }
    child.wait_with_output().unwrap()
}

fn status(here: &Path, folder: &str) -> String {
    let status = json(&stdout(&run(here, &["--json", "status", folder])));
    status["status"].as_str().unwrap().to_string()
}

#[test]
#[cfg(target_os = "linux")]
fn a_run_survives_the_loss_of_its_messages() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), short()).unwrap();
    done(here, &["shear", "case.toml", "--out", "straight"]);

    let output = granum(here, &["shear", "case.toml", "--out", "full"]).stderr(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    let unread = granum(here, &["shear", "case.toml", "--out", "unread"]);
    let output = with_closed_pipe(unread, true);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(stdout(&output).contains("wrote unread"), "{}", stdout(&output));
    for name in ["full", "unread"] {
        assert_eq!(status(here, name), "finished");
        assert_same(&here.join("straight"), &here.join(name));
    }

    // The exit status of a failure does not depend on whether its message could be written.
    for arguments in [&["shear", "nothing.toml"][..], &["--json", "shear", "nothing.toml"]] {
        let output = granum(here, arguments).stderr(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
    }
    let output = granum(here, &["--json", "shear"]).stderr(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

#[test]
#[cfg(target_os = "linux")]
fn a_lost_output_is_an_error_or_a_quiet_end() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), short()).unwrap();

    // The disk of the output is full: the results in the folder are complete, and the message says so.
    let output = granum(here, &["shear", "case.toml", "--out", "run"]).stdout(full()).output().unwrap();
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot write to standard output") && told.contains("No space left"), "{told}");
    assert!(told.contains("is complete"), "{told}");
    assert_eq!(status(here, "run"), "finished");
    for arguments in [&["--json", "digest", "run"][..], &["--help"], &["run", "--help"], &["--version"]] {
        let output = granum(here, arguments).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("cannot write to standard output"), "{}", stderr(&output));
    }

    // The reader has ended, as `| head -1` does: there is nobody who could be told.
    let bench =
        ["bench", "--only", "dem", "--law", "hertz,no-slip", "--steps", "1", "--grains", "5000,10000"];
    for arguments in [&["--json", "digest", "run"][..], &["schema"], &["--help"], &bench] {
        let output = with_closed_pipe(granum(here, arguments), false);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        assert_eq!(stderr(&output), "", "{arguments:?}");
    }
}

/// Starts a test through a shell and sends SIGHUP as soon as the test has a checkpoint.
#[cfg(target_os = "linux")]
fn hung_up(here: &Path, folder: &str, before: &str) -> Output {
    let script = format!("{before} exec \"$0\" shear case.toml --out {folder}");
    // Where the tests themselves run under nohup, the signal would be ignored.
    let child = Command::new("env")
        .args(["--default-signal=HUP", "sh", "-c", &script, env!("CARGO_BIN_EXE_granum")])
        .current_dir(here)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !here.join(folder).join("checkpoint").exists() {
        assert!(started.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    // A terminal that is closed may send the signal twice, from the shell and from the system.
    for _ in 0..2 {
        let sent = Command::new("kill").args(["-HUP", &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }
    child.wait_with_output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_goes_away_ends_a_run_in_good_order_unless_it_is_to_survive() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), short()).unwrap();
    done(here, &["shear", "case.toml", "--out", "straight"]);

    let output = hung_up(here, "ended", "");
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("continue with `granum resume ended`"), "{told}");
    assert_eq!(status(here, "ended"), "interrupted");
    done(here, &["resume", "ended"]);
    assert_same(&here.join("straight"), &here.join("ended"));

    // As with nohup.
    let output = hung_up(here, "survived", "trap '' HUP;");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(status(here, "survived"), "finished");
    assert_same(&here.join("straight"), &here.join("survived"));

    // Closed descriptors are those of a device that takes everything, and never those of a file of the run.
    let script = "exec \"$0\" shear case.toml --out closed >&- 2>&- <&-";
    let ended =
        Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_granum")]).current_dir(here).status();
    assert_eq!(ended.unwrap().code(), Some(0));
    assert_same(&here.join("straight"), &here.join("closed"));
}
