//! SIGKILL at random moments of the coordinator of a campaign, of the processes of its runs, and of all of them.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::{assert_same, assert_same_but, done};

/// Kills in a usual test; `GRANUM_KILLS=100` for more.
const KILLS: usize = 12;

const SAND: &str = "[grains]\ncount = 100\n[preparation]\nfriction = 0.1\nsolid_fraction = 'none'\ninertial_number = 1e-2\n\
                    unbalanced_force = 2e-2\n[shear]\ndeviator_strain = 0.04\ninertial_number = 3e-3\n[recording]\nstates = 8\n\
                    observations_per_state = 3\n";
/// Five runs, of which two share their sample.
const PLAN: &str = "case = 'sand.toml'\n[design]\nkind = 'list'\nrows = [{ mu = 0.2, e = 0.04 }, { mu = 0.2, e = 0.02 }, \
                    { mu = 0.3, e = 0.04 }, { mu = 0.4, e = 0.02 }, { mu = 0.5, e = 0.03 }]\n[[variable]]\nname = 'mu'\n\
                    key = 'grains.material.friction'\n[[variable]]\nname = 'e'\nkey = 'shear.deviator_strain'\n";

/// The runs are far too fast, which this accepts.
const ACCEPT: &str = "['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', 'unbalanced_force < 10', \
                      'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1', 'sample_largest_overlap < 1']";

/// A reproducible sequence of pseudo-random numbers (Lehmer generator).
struct Random(u64);

impl Random {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0 * 48271 % 2_147_483_647;
        self.0 % most
    }
}

fn start(here: &Path, out: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(["campaign", "plan.toml", "--workers", "3", "--checkpoint-every", "0.02", "--out", out])
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The processes that a process started.
fn children(of: u32) -> Vec<u32> {
    let tasks = fs::read_dir(format!("/proc/{of}/task")).into_iter().flatten().flatten();
    let children = tasks.filter_map(|task| fs::read_to_string(task.path().join("children")).ok());
    children
        .flat_map(|text| text.split_whitespace().filter_map(|id| id.parse().ok()).collect::<Vec<_>>())
        .collect()
}

fn kill(process: u32) {
    // It may have ended by itself.
    let _ = Command::new("kill").args(["-9", &process.to_string()]).stderr(Stdio::null()).status();
}

/// Runs the campaign once with kills; returns how many there were, and true if it ended by itself with all runs finished.
fn disturbed(here: &Path, out: &str, random: &mut Random) -> (usize, bool) {
    let mut child = start(here, out);
    let begun = Instant::now();
    let mut kills = 0;
    loop {
        let after = Duration::from_millis(30 + random.below(300));
        let since = Instant::now();
        while since.elapsed() < after {
            if let Some(status) = child.try_wait().unwrap() {
                return (kills, status.success());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        assert!(begun.elapsed() < Duration::from_secs(120), "the campaign hangs");
        let workers = children(child.id());
        match random.below(3) {
            // A run alone; the coordinator tries it again.
            0 => {
                if let Some(worker) = workers.get(random.below(workers.len().max(1) as u64) as usize) {
                    kill(*worker);
                    kills += 1;
                }
            }
            what => {
                child.kill().unwrap();
                if what == 2 {
                    workers.into_iter().for_each(kill);
                }
                child.wait().unwrap();
                return (kills + 1, false);
            }
        }
    }
}

#[test]
fn a_campaign_that_is_killed_again_and_again_ends_with_the_same_bytes() {
    let folders = |here: &Path, out: &str| {
        for part in ["tests", "samples"] {
            assert!(assert_same(&here.join("straight").join(part), &here.join(out).join(part)) > 5);
        }
    };
    killed_again_and_again(PLAN, 20_261_124, &folders);
}

/// The folders of runs are thrown away as soon as their rows are in: whatever is killed, none is lost, and none is left.
#[test]
fn a_campaign_without_folders_that_is_killed_ends_with_the_same_data_set() {
    let nothing_left = |here: &Path, out: &str| {
        for part in ["tests", "samples", ".granum-removed"] {
            let left = fs::read_dir(here.join(out).join(part)).map_or(0, Iterator::count);
            assert_eq!(left, 0, "{part}");
        }
    };
    killed_again_and_again(&format!("keep = 'dataset'\naccept = {ACCEPT}\n{PLAN}"), 7, &nothing_left);
}

/// Kills the campaign of a plan until it was killed often enough, and compares it with an undisturbed one.
fn killed_again_and_again(plan: &str, seed: u64, compare: &dyn Fn(&Path, &str)) {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("sand.toml"), SAND).unwrap();
    fs::write(here.join("plan.toml"), plan).unwrap();
    // All are made in a folder of one name, since the record of a test names the folder of its sample.
    done(here, &["campaign", "plan.toml", "--out", "study"]);
    fs::rename(here.join("study"), here.join("straight")).unwrap();
    let wanted = std::env::var("GRANUM_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(KILLS);
    let mut random = Random(seed);
    let (mut kills, mut round) = (0, 0);
    while kills < wanted {
        for _ in 0..200 {
            let (more, finished) = disturbed(here, "study", &mut random);
            kills += more;
            if finished {
                break;
            }
            // What a run was killed too often for is tried again by the same command.
        }
        done(here, &["campaign", "plan.toml", "--out", "study"]);
        compare(here, "study");
        let bytes = |folder: &str| fs::read(here.join(folder).join("campaign.json")).unwrap();
        assert!(bytes("straight") == bytes("study"));
        if here.join("straight/dataset").is_dir() {
            let but = ["seconds.parquet"];
            assert!(assert_same_but(&but, &here.join("straight/dataset"), &here.join("study/dataset")) > 5);
        }
        fs::rename(here.join("study"), here.join(format!("killed-{round}"))).unwrap();
        round += 1;
    }
}
