//! SIGKILL at random moments of preparation, test and training.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use granum_dem::simulation::Simulation;
use granum_io::{Case, Run};

use crate::common::{run, stdout};
use crate::{CASE, assert_same, done, files};

/// A reproducible sequence of pseudo-random numbers (Lehmer generator).
struct Random(u64);

impl Random {
    fn milliseconds(&mut self, most: u64) -> Duration {
        self.0 = self.0 * 48271 % 2_147_483_647;
        Duration::from_millis(1 + self.0 % most)
    }
}

fn spawn(here: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(arguments)
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Starts the program and kills it after a given time; returns false if it had already ended.
fn killed(here: &Path, arguments: &[&str], after: Duration) -> bool {
    let mut child = spawn(here, arguments);
    let started = Instant::now();
    while started.elapsed() < after && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1).min(after));
    }
    let _ = child.kill();
    let output = child.wait_with_output().unwrap();
    let ended = output.status.code().is_some();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(!ended || output.status.success(), "granum {}: {told}", arguments.join(" "));
    !ended
}

/// Checks that every complete file in a folder can be read in its format.
fn check_readable(folder: &Path) {
    for path in files(folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = || std::fs::read_to_string(&path).unwrap();
        match name.as_str() {
            ".granum-lock" => {}
            // This file was being written at the moment of the kill; the next process removes or replaces it.
            _ if name.ends_with(".granum-unfinished") || name.ends_with(".part") => {}
            "states.jsonl" => {
                let text = text();
                // The last line may be cut short.
                let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
                whole.lines().for_each(|line| drop(crate::common::json(line)));
            }
            "case.toml" => drop(Case::read(&path).unwrap()),
            "checkpoint" | "checkpoint.previous" => {
                drop(Simulation::restore(&std::fs::read(&path).unwrap()).unwrap());
            }
            _ if name.ends_with(".json") => drop(crate::common::json(&text())),
            _ if name.ends_with(".parquet") => drop(granum_io::formats::parquet::read(&path, None).unwrap()),
            // The state of an unfinished network: a checksum and the content.
            _ if name.ends_with(".unfinished") => {
                let text = text();
                let (sum, rest) = text.split_once('\n').unwrap();
                assert!(sum.len() == 8 && rest.ends_with('\n'), "{name}");
                crate::common::json(rest);
            }
            _ => panic!("what is {}?", path.display()),
        }
    }
}

fn kill_tests_of_grains(here: &Path, random: &mut Random) -> BTreeMap<String, usize> {
    std::fs::write(here.join("case.toml"), CASE).unwrap();
    done(here, &["shear", "case.toml", "--out", "straight"]);
    let mut kills: BTreeMap<String, usize> = BTreeMap::new();
    const PHASES: [&str; 3] = ["compaction", "relaxation", "shear"];
    for round in 0.. {
        if kills.values().sum::<usize>() >= 25 && PHASES.iter().all(|phase| kills.contains_key(*phase)) {
            break;
        }
        assert!(round < 40, "{kills:?}");
        let name = format!("killed-{round}");
        let folder = here.join(&name);
        loop {
            let begun = folder.join("run.json").is_file();
            let often = ["--checkpoint-every", "0.02"];
            let arguments = if begun {
                [&["resume", &name][..], &often].concat()
            } else {
                [&["shear", "case.toml", "--out", &name][..], &often].concat()
            };
            if !killed(here, &arguments, random.milliseconds(250)) {
                break;
            }
            let mut phase = "nothing".to_string();
            if folder.is_dir() {
                check_readable(&folder);
                if folder.join("run.json").is_file() {
                    let record = Run::at(&folder).unwrap().record().unwrap();
                    // The number of the trial is removed.
                    phase = record.phase.split(',').next().unwrap().to_string();
                }
            }
            *kills.entry(phase).or_default() += 1;
        }
        assert!(assert_same(&here.join("straight"), &folder) >= 10);
        let digests = run(here, &["digest", "straight", &name]);
        let told = stdout(&digests);
        let digests: Vec<&str> = told.lines().map(|line| line.split(' ').next().unwrap()).collect();
        assert!(digests.len() == 2 && digests[0] == digests[1], "{told}");
    }
    kills
}

fn kill_training(here: &Path, random: &mut Random) -> usize {
    let case = CASE
        .replace("deviator_strain = 0.05", "deviator_strain = 0.3")
        .replace("inertial_number = 3e-3", "inertial_number = 1e-2")
        .replace("solid_fraction = 0.6", "friction = 0.1\nsolid_fraction = \"none\"")
        .replace("states = 8", "states = 40");
    std::fs::write(here.join("long.toml"), case).unwrap();
    done(here, &["shear", "long.toml", "--out", "run"]);
    let train = |out: &str, threads: &str| {
        format!(
            "train run --out {out} --trainer traingdx --epoch-factor 2e-3 --threads {threads} --checkpoint-every 0.02"
        )
    };
    done(here, &train("study", "1").split(' ').collect::<Vec<_>>());
    let mut kills = 0;
    for round in 0.. {
        if kills >= 12 {
            break;
        }
        assert!(round < 40, "{kills}");
        let name = format!("killed-study-{round}");
        let folder = here.join(&name);
        // A process needs some time to read what is finished: each may live a little longer, so that a slow computer ends too.
        let mut longest = 200;
        loop {
            longest += 20;
            let begun = folder.join("training.json").is_file();
            // The run is continued alternately with `resume` and with the original command.
            let line = if begun && kills % 2 == 1 {
                format!("resume {name} --threads 2 --checkpoint-every 0.02")
            } else {
                train(&name, "2")
            };
            if !killed(here, &line.split(' ').collect::<Vec<_>>(), random.milliseconds(longest)) {
                break;
            }
            kills += 1;
            if folder.is_dir() {
                check_readable(&folder);
            }
            // The last file had already been written when the process was killed, so that nothing is left to do.
            if folder.join("study.json").is_file() {
                break;
            }
        }
        // The files are 30 surrogates, the study and its plan.
        assert_eq!(assert_same(&here.join("study"), &folder), 32);
    }
    kills
}

/// The report, the summary, the figures, all runs and networks: everything but the times.
#[test]
fn a_reproduction_killed_again_and_again_ends_in_the_same_bytes() {
    const MOST: usize = 6;
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let mut random = Random(19_052_025);
    let line = |out: &str, threads: &str| {
        format!(
            "reproduce --quick --grains 100 --training-runs 0 --out {out} --threads {threads} \
             --checkpoint-every 0.05"
        )
    };
    done(here, &line("straight", "2").split(' ').collect::<Vec<_>>());
    let mut kills = 0;
    loop {
        let command = match kills % 2 {
            1 => "resume killed --threads 1 --checkpoint-every 0.05".to_string(),
            _ => line("killed", "2"),
        };
        // After some kills it may end.
        let moment = if kills < MOST { random.milliseconds(2000) } else { Duration::from_secs(600) };
        if !killed(here, &command.split(' ').collect::<Vec<_>>(), moment) {
            break;
        }
        kills += 1;
    }
    println!("{kills} kills of a reproduction");
    assert!(kills >= 2, "{kills}");
    // Killed between its last file and its tidying up: what is left over goes with the next call.
    let left = here.join("killed/sizes");
    std::fs::create_dir(&left).unwrap();
    std::fs::write(left.join("F1-1-neurons-seed-1-1.json"), "left").unwrap();
    done(here, &["resume", "killed"]);
    // Three runs of ten files or more, 30 surrogates with two files beside them, figures, report, summary and description.
    let same = assert_same(&here.join("straight"), &here.join("killed"));
    assert!(same >= 90, "{same}");
    for name in ["report.html", "summary.json", "models/study.json", "runs/unseen-12/run.json"] {
        assert!(crate::contents(&here.join("straight")).contains_key(Path::new(name)), "{name}");
    }
    for name in ["seconds.json", "speed.html"] {
        assert!(here.join("killed").join(name).is_file(), "{name}");
    }
}

#[test]
fn killed_again_and_again_everything_ends_in_the_same_bytes() {
    let base = tempfile::tempdir().unwrap();
    let mut random = Random(20_061_121);
    let grains = kill_tests_of_grains(base.path(), &mut random);
    let training = kill_training(base.path(), &mut random);
    let total = grains.values().sum::<usize>() + training;
    println!("{total} kills: {training} in training, {grains:?}");
    for phase in ["compaction", "relaxation", "shear"] {
        assert!(grains.contains_key(phase), "{grains:?}");
    }
    assert!(training >= 12 && total >= 37, "{training} {grains:?}");
}
