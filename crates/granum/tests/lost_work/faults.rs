//! Whole campaigns on a disk and with a clock that fail as a seed decides, without locks, on a disk that is full, and after Ctrl-C.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{json, run, stderr, stdout};
use crate::{assert_same, done, files};

/// A drained triaxial test that takes a tenth of a second.
pub const SAND: &str = "[grains]\ncount = 60\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\n\
                    tangential = 'no-slip'\n[preparation]\nmean_stress = '100 kPa'\nfriction = 0.1\nsolid_fraction = 'none'\n\
                    inertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.01\n\
                    inertial_number = 1e-2\nstates = 4\n";
/// Four runs of two frictions and two strains, so that each of two samples serves two tests.
const PLAN: &str = "case = 'sand.toml'\n[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'friction'\n\
                    key = 'grains.material.friction'\nvalues = [0.2, 0.4]\n[[variable]]\nname = 'strain'\n\
                    key = 'stage.1.axial_strain'\nvalues = ['1 %', '1.5 %']\n";
/// The command by which it is carried out.
const CAMPAIGN: [&str; 4] = ["campaign", "plan.toml", "--out", "study"];

fn folder_with_plan() -> tempfile::TempDir {
    let base = tempfile::tempdir().unwrap();
    fs::write(base.path().join("sand.toml"), SAND).unwrap();
    fs::write(base.path().join("plan.toml"), PLAN).unwrap();
    base
}

/// Carries out the plan without disturbance, and puts its folder aside.
fn straight(here: &Path) {
    done(here, &CAMPAIGN);
    fs::rename(here.join("study"), here.join("straight")).unwrap();
}

/// The runs, the samples and the list of runs are those of an undisturbed campaign, and nothing is left of what was not completed.
fn assert_as_undisturbed(here: &Path) {
    for part in ["tests", "samples"] {
        assert!(assert_same(&here.join("straight").join(part), &here.join("study").join(part)) > 5);
    }
    let bytes = |folder: &str| fs::read(here.join(folder).join("campaign.json")).unwrap();
    assert!(bytes("straight") == bytes("study"));
    let unfinished = |file: &PathBuf| file.to_string_lossy().contains("granum-unfinished");
    assert_eq!(
        files(&here.join("study")).into_iter().filter(unfinished).collect::<Vec<_>>(),
        Vec::<PathBuf>::new()
    );
    assert_eq!(fs::read_dir(here.join("study/claims")).unwrap().count(), 0);
}

/// The library that stands between a program and the system; `None`, with a word about it, where it cannot be compiled.
fn library(here: &Path, test: &str) -> Option<PathBuf> {
    let (source, library) = (here.join("faults.c"), here.join("faults.so"));
    fs::write(&source, include_str!("faults.c")).unwrap();
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .arg(&library)
        .arg(&source)
        .arg("-ldl")
        .status();
    if compiled.is_ok_and(|status| status.success()) {
        return Some(library);
    }
    eprintln!("{test}: skipped, since there is no C compiler `cc` here");
    None
}

fn granum(here: &Path, library: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
    command.current_dir(here).env("LD_PRELOAD", library).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Writes that fail in whole or in part, files that cannot be flushed or renamed, and a clock that jumps by years: whatever a call says,
/// nothing is damaged, and the same command ends with the same bytes.
#[test]
fn faults_of_disk_and_clock_in_a_whole_campaign_change_no_byte() {
    let base = folder_with_plan();
    let here = fs::canonicalize(base.path()).unwrap();
    let Some(library) = library(&here, "faults_of_disk_and_clock_in_a_whole_campaign_change_no_byte") else {
        return;
    };
    straight(&here);
    let (mut failed, mut finished) = (0, 0);
    for seed in 0..30 {
        let output = granum(&here, &library)
            .args(["campaign", "plan.toml", "--checkpoint-every", "0.02", "--out", "study"])
            .env("FAULTS_SEED", seed.to_string())
            .env("FAULTS_ONE_IN", if seed % 2 == 0 { "60" } else { "250" })
            .env("FAULTS_BELOW", here.join("study"))
            .env("FAULTS_LOG", here.join("faults.log"))
            .output()
            .unwrap();
        let told = stderr(&output);
        assert!(
            matches!(output.status.code(), Some(0 | 1)) && !told.contains("panicked"),
            "seed {seed}: {told}"
        );
        if !output.status.success() {
            failed += 1;
            continue;
        }
        finished += 1;
        // What a process could not remove for a fault is removed by one without.
        done(&here, &CAMPAIGN);
        assert_as_undisturbed(&here);
        if finished == 2 {
            break;
        }
        fs::remove_dir_all(here.join("study")).unwrap();
    }
    let all = fs::read_to_string(here.join("faults.log")).unwrap();
    for letter in ['w', 's', 'r'] {
        assert!(all.contains(letter), "{all}");
    }
    assert!(finished == 2 && failed >= 3, "{failed} calls failed, {finished} came to their end");
}

/// On some network file systems locks hold within a machine only, or are missing: claims keep processes apart.
#[test]
fn without_locks_a_second_coordinator_is_refused_and_runs_are_made_by_one_process() {
    let base = folder_with_plan();
    let here = base.path();
    let name = "without_locks_a_second_coordinator_is_refused_and_runs_are_made_by_one_process";
    let Some(library) = library(here, name) else { return };
    // Each run takes half a second, so that processes meet.
    fs::write(
        here.join("plan.toml"),
        PLAN.replace("[design]", "[set]\nstage.1.inertial_number = 2e-3\n[design]"),
    )
    .unwrap();
    straight(here);
    for locks in ["deaf", "missing"] {
        let start = |arguments: &[&str]| {
            granum(here, &library).args(arguments).env("FAULTS_FLOCK", locks).spawn().unwrap()
        };
        // Four processes at the same two runs, which need the same sample.
        let listed = granum(here, &library)
            .args(CAMPAIGN)
            .args(["--json", "--list-jobs"])
            .env("FAULTS_FLOCK", locks)
            .output()
            .unwrap();
        let jobs = json(&stdout(&listed));
        let names: Vec<&str> = jobs["jobs"]
            .as_array()
            .unwrap()
            .iter()
            .map(|job| job.as_str().unwrap().rsplit(' ').next().unwrap())
            .collect();
        let processes: Vec<Child> = [0, 1, 1, 0]
            .map(|k| start(&["campaign", "run", "--checkpoint-every", "0", "study", names[k]]))
            .into();
        for process in processes {
            let output = process.wait_with_output().unwrap();
            assert!(output.status.success(), "{locks}: {}", stderr(&output));
        }
        // One coordinator, and a second one while the first is at work.
        let first = start(&["campaign", "plan.toml", "--out", "study", "--workers", "1"]);
        let since = Instant::now();
        while !here.join("study/claims/campaign.1").exists() {
            assert!(since.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        }
        let second = start(&CAMPAIGN).wait_with_output().unwrap();
        let told = stderr(&second);
        assert_eq!(second.status.code(), Some(1), "{told}");
        assert!(
            told.contains(&format!("study is in use by another granum process (process {} on ", first.id())),
            "{told}"
        );
        assert!(first.wait_with_output().unwrap().status.success());
        assert_as_undisturbed(here);
        fs::remove_dir_all(here.join("study")).unwrap();
    }
}

/// A disk of its own that is too small: what does not fit is told, and with room the same command goes on.
#[test]
fn a_campaign_on_a_disk_that_becomes_full_goes_on_when_there_is_room() {
    let base = folder_with_plan();
    let here = base.path();
    // A file system of 200 kB in memory, which exists for this one process and its children.
    let script = "mkdir -p disk && mount -t tmpfs -o size=200k none disk || exit 77\n\
                  \"$0\" campaign plan.toml --out disk/study > told 2>&1; echo $? > status\n\
                  \"$0\" --json campaign status disk/study > full.json; df -P disk | tail -n 1 >> told\n\
                  mount -o remount,size=50m none disk\n\
                  \"$0\" campaign plan.toml --out disk/study > again 2>&1 && cp -r disk/study on-small-disk";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, env!("CARGO_BIN_EXE_granum")])
        .current_dir(here)
        .output();
    if output
        .as_ref()
        .map_or(true, |output| output.status.code() == Some(77) || stderr(output).contains("unshare"))
    {
        eprintln!(
            "a_campaign_on_a_disk_that_becomes_full_goes_on_when_there_is_room: skipped, since no file system can be mounted here"
        );
        return;
    }
    let read = |name: &str| fs::read_to_string(here.join(name)).unwrap_or_default();
    let told = read("told");
    assert_eq!(read("status").trim(), "1", "{told}");
    assert!(told.contains("No space left on device") && told.contains("runs failed"), "{told}");
    assert!(json(&read("full.json"))["counts"]["failed"].as_u64().unwrap() > 0, "{told}");
    assert!(output.unwrap().status.success(), "{}", read("again"));
    straight(here);
    // The record of a test names the folder of its sample, which is that of another place here; all else is the same.
    let status = json(&stdout(&run(here, &["--json", "campaign", "status", "straight"])));
    for run in status["runs"].as_array().unwrap() {
        let name = run["name"].as_str().unwrap();
        let series = |folder: &str| {
            fs::read(here.join(folder).join("tests").join(name).join("series.parquet")).unwrap()
        };
        assert!(series("straight") == series("on-small-disk"), "{name}");
    }
}

/// Starts a campaign in a process group of its own, as a terminal does, and sends a signal to all of it when runs have checkpoints.
fn interrupted(here: &Path, signal: &str) -> Output {
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(["campaign", "slow.toml", "--out", "study", "--workers", "2", "--checkpoint-every", "0.05"])
        .current_dir(here)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .process_group(0)
        .spawn()
        .unwrap();
    // The process of a run has its claim, and one of them, now or earlier, a checkpoint.
    let folders = |name: &str| fs::read_dir(here.join("study").join(name)).into_iter().flatten().flatten();
    let is_claimed =
        || folders("claims").any(|file| !file.file_name().to_string_lossy().starts_with("campaign"));
    let has_checkpoint = || folders("tests").any(|run| run.path().join("checkpoint").exists());
    let since = Instant::now();
    while !(is_claimed() && has_checkpoint()) {
        assert!(since.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
    let group = format!("-{}", child.id());
    assert!(Command::new("kill").args([signal, "--", &group]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

/// Ctrl-C reaches the coordinator and the processes of the runs at once.
#[test]
fn ctrl_c_ends_a_campaign_in_good_order() {
    let base = folder_with_plan();
    let here = base.path();
    let slow = PLAN
        .replace(
            "case = 'sand.toml'",
            "case = 'sand.toml'\n[set]\ngrains.count = 150\nstage.1.inertial_number = 2e-3",
        )
        .replace("['1 %', '1.5 %']", "['4 %', '5 %']");
    fs::write(here.join("slow.toml"), slow).unwrap();
    for signal in ["-INT", "-TERM"] {
        let output = interrupted(here, signal);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(130), "{told}");
        assert!(
            told.contains("interrupted; ")
                && told.contains("continue with the same command or `granum resume study`"),
            "{told}"
        );
        assert!(!told.contains("tried again") && !told.contains("failed"), "{told}");
        let status = json(&stdout(&run(here, &["--json", "campaign", "status", "study"])));
        assert_eq!((&status["at_work"], &status["done"]), (&false.into(), &false.into()), "{status}");
        assert_eq!(
            (&status["counts"]["running"], &status["counts"]["failed"]),
            (&0.into(), &0.into()),
            "{status}"
        );
        assert!(status["counts"]["unfinished"].as_u64().unwrap() > 0, "{status}");
        let journal = fs::read_to_string(here.join("study/journal.jsonl")).unwrap();
        assert!(journal.contains("\"interrupted\""), "{journal}");
        let progress = fs::read_to_string(here.join("study/progress.txt")).unwrap();
        assert!(progress.lines().next_back().unwrap().contains("of 4 runs finished"), "{progress}");
        assert_eq!(fs::read_dir(here.join("study/claims")).unwrap().count(), 0);
    }
    done(here, &["campaign", "slow.toml", "--out", "study"]);
    fs::rename(here.join("study"), here.join("interrupted")).unwrap();
    done(here, &["campaign", "slow.toml", "--out", "study"]);
    fs::rename(here.join("interrupted"), here.join("straight")).unwrap();
    assert_as_undisturbed(here);
}

/// Another process, on this or another machine, asks for the end.
#[test]
fn a_campaign_that_is_cancelled_goes_on_later() {
    let base = folder_with_plan();
    let here = base.path();
    let slow = PLAN
        .replace(
            "case = 'sand.toml'",
            "case = 'sand.toml'\n[set]\ngrains.count = 150\nstage.1.inertial_number = 1e-4",
        )
        .replace("['1 %', '1.5 %']", "['8 %', '9 %']");
    fs::write(here.join("slow.toml"), slow).unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        // One run at a time: runs that have begun come to their end, and with a processor for each
        // of the four none would be left to be called off.
        .args(["campaign", "slow.toml", "--out", "study", "--workers", "1"])
        .current_dir(here)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let since = Instant::now();
    while !here.join("study/claims/campaign.1").exists() {
        assert!(since.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
    let told = stdout(&run(here, &["campaign", "cancel", "study"]));
    assert!(told.contains("was asked to end"), "{told}");
    let output = child.wait_with_output().unwrap();
    assert!(
        output.status.success() && stdout(&output).contains("stopped before the end"),
        "{}",
        stdout(&output)
    );
    assert!(!here.join("study/stop-requested").exists());
    let told = stdout(&run(here, &["campaign", "cancel", "study"]));
    assert!(told.contains("nothing is queued or goes on"), "{told}");
}
