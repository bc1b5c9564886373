//! A campaign on a real Slurm of one node, which `scripts/slurm-here` starts: jobs are cancelled, lose their node and run out of time.
#![cfg(target_os = "linux")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::{json, stderr, stdout};
use crate::faults::SAND;
use crate::{assert_same, done};

const NAME: &str = "a_campaign_on_slurm_loses_nothing_and_has_the_bytes_of_a_local_one";
/// Twenty-five frictions with four strains each: 100 runs, of which four share a sample.
const PLAN: &str = "case = 'sand.toml'\n[set]\ngrains.count = 50\n[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'friction'\n\
                    key = 'grains.material.friction'\nfrom = 0.2\nto = 0.6\nlevels = 25\n[[variable]]\nname = 'strain'\n\
                    key = 'stage.1.axial_strain'\nvalues = ['0.6 %', '0.8 %', '1 %', '1.2 %']\n";
/// Two runs of a few seconds.
const LONG: &str = "case = 'sand.toml'\n[set]\ngrains.count = 150\nstage.1.inertial_number = 2e-3\nstage.1.axial_strain = 0.2\n\
                    [design]\nkind = 'list'\nrows = [{ friction = 0.3 }, { friction = 0.5 }]\n[[variable]]\nname = 'friction'\n\
                    key = 'grains.material.friction'\n";
/// The page, of which the first commands are executed as they stand there.
const PAGE: &str = include_str!("../../../../docs/src/cluster.md");
/// An association with a limit, as `sacctmgr` tells it: keeping accounts would need a database server.
const SACCTMGR: &str = "#!/bin/sh\ncase \"$*\" in *assoc*) echo 'physics||12' ;; *) exit 1 ;; esac\n";

/// A Slurm that ends with the test.
struct Slurm {
    folder: PathBuf,
    script: PathBuf,
}

impl Slurm {
    /// Starts it; `None` where it is not installed.
    fn start(folder: &Path) -> Option<Slurm> {
        let path = std::env::var("PATH").unwrap_or_default() + ":/usr/sbin:/sbin";
        let is_there = |name: &str| path.split(':').any(|folder| Path::new(folder).join(name).is_file());
        if let Some(missing) =
            ["slurmctld", "slurmd", "munged", "sbatch", "squeue"].iter().find(|name| !is_there(name))
        {
            eprintln!(
                "{NAME}: skipped, since there is no {missing} here (Debian: slurmctld slurmd slurm-client munge)"
            );
            return None;
        }
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/slurm-here");
        let slurm = Slurm { folder: folder.join("slurm"), script };
        fs::create_dir_all(folder.join("bin")).unwrap();
        let shim = folder.join("bin/sacctmgr");
        fs::write(&shim, SACCTMGR).unwrap();
        fs::set_permissions(&shim, fs::Permissions::from_mode(0o755)).unwrap();
        slurm.make("start");
        Some(slurm)
    }

    fn make(&self, what: &str) {
        let path = std::env::var("PATH").unwrap_or_default() + ":/usr/sbin:/sbin";
        let mut command = Command::new("bash");
        command
            .arg(&self.script)
            .arg(what)
            .arg(&self.folder)
            .env("PATH", path)
            .env("MAX_ARRAY_SIZE", "8")
            .env("NODE_CPUS", "3");
        assert!(command.status().unwrap().success(), "{what}");
    }

    /// With the limit of an association, and granum by its name.
    fn command(&self, here: &Path, program: &str, arguments: &[&str]) -> Output {
        let own = Path::new(env!("CARGO_BIN_EXE_granum")).parent().unwrap();
        let shims = self.folder.with_file_name("bin");
        let rest = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{}:{rest}", shims.display(), own.display());
        let mut command = Command::new(program);
        command
            .args(arguments)
            .current_dir(here)
            .env("PATH", path)
            .env("SLURM_CONF", self.folder.join("slurm.conf"));
        command.output().unwrap()
    }

    fn told(&self, here: &Path, program: &str, arguments: &[&str]) -> String {
        let output = self.command(here, program, arguments);
        assert!(output.status.success(), "{program} {}: {}", arguments.join(" "), stderr(&output));
        stdout(&output)
    }

    fn granum(&self, here: &Path, arguments: &[&str]) -> Output {
        let output = self.command(here, env!("CARGO_BIN_EXE_granum"), arguments);
        assert!(output.status.success(), "granum {}: {}", arguments.join(" "), stderr(&output));
        output
    }

    fn status(&self, here: &Path, folder: &str) -> Value {
        json(&stdout(&self.granum(here, &["--json", "campaign", "status", folder])))
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        let stopped = Command::new("bash").arg(&self.script).arg("stop").arg(&self.folder).status();
        if !stopped.is_ok_and(|status| status.success()) {
            eprintln!("{NAME}: Slurm in {} was not stopped", self.folder.display());
        }
    }
}

/// Waits until something holds.
fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < Duration::from_secs(300), "{what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// The command that submits what is left.
fn submission<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["campaign", "plan.toml", "--out", "study", "--scheduler", "slurm"], more].concat()
}

fn count(status: &Value, word: &str) -> u64 {
    status["counts"][word].as_u64().unwrap()
}

/// The elements of jobs that wait or go on.
fn elements(status: &Value) -> u64 {
    let jobs = status["jobs"].as_array().unwrap().iter();
    jobs.map(|job| job["queued"].as_u64().unwrap() + job["running"].as_u64().unwrap()).sum()
}

#[test]
fn a_campaign_on_slurm_loses_nothing_and_has_the_bytes_of_a_local_one() {
    let base = tempfile::tempdir().unwrap();
    let here = &fs::canonicalize(base.path()).unwrap();
    let Some(slurm) = Slurm::start(here) else { return };
    fs::write(here.join("sand.toml"), SAND).unwrap();
    fs::write(here.join("plan.toml"), PLAN).unwrap();
    let long = &here.join("long");
    fs::create_dir(long).unwrap();
    fs::write(long.join("sand.toml"), SAND).unwrap();
    fs::write(long.join("plan.toml"), LONG).unwrap();
    // A header with a directive, and a command that needs the folder from which the jobs were submitted.
    fs::write(long.join("header"), "#SBATCH --nice=5\n. ./settings\n").unwrap();
    fs::write(long.join("settings"), "export SETTINGS=read\n").unwrap();

    out_of_time(&slurm, long);
    cancelled_lost_and_throttled(&slurm, here);
    drop(slurm);

    // The same on this machine.
    for here in [here, long] {
        let by_slurm = here.join("by-slurm");
        fs::rename(here.join("study"), &by_slurm).unwrap();
        done(here, &["campaign", "plan.toml", "--out", "study"]);
        for part in ["tests", "samples"].iter().filter(|part| here.join("study").join(part).is_dir()) {
            assert!(assert_same(&here.join("study").join(part), &by_slurm.join(part)) > 5);
        }
        let bytes = |folder: &Path| fs::read(folder.join("campaign.json")).unwrap();
        assert!(bytes(&here.join("study")) == bytes(&by_slurm));
    }
}

/// A job whose time is over writes a checkpoint; the same command goes on from there.
fn out_of_time(slurm: &Slurm, here: &Path) {
    let command = submission(&[
        "--per-task",
        "2",
        "--time",
        "1 min",
        "--checkpoint-every",
        "0.05",
        "--header",
        "header",
    ]);
    slurm.granum(here, &command);
    let script = fs::read_to_string(here.join("study/jobs/0001.sh")).unwrap();
    assert!(script.starts_with("#!/bin/sh\n#SBATCH --nice=5\ncd "), "{script}");
    assert!(script.contains("\n. ./settings\nexec "), "{script}");
    // It says where its commands begin, and not where the campaign is.
    assert!(!script.contains(&format!("{}", here.join("study").display())), "{script}");
    wait_for("a run begins", || count(&slurm.status(here, "study"), "running") == 1);
    let checkpoint = || {
        let runs = fs::read_dir(here.join("study/tests")).into_iter().flatten().flatten();
        runs.map(|run| run.path().join("checkpoint")).find(|file| file.exists())
    };
    wait_for("a checkpoint", || checkpoint().is_some());
    // The run stands still until its time is over, so that the test does not depend on the speed of the machine.
    let run = checkpoint().unwrap().parent().unwrap().to_path_buf();
    let of_run = format!("campaign run --watched .* {} ", here.join("study").display());
    let processes = slurm.told(here, "pgrep", &["-f", &of_run]);
    slurm.told(here, "kill", &["-STOP", processes.lines().next().unwrap()]);
    let status = slurm.status(here, "study");
    let job = status["jobs"][0]["job"].as_str().unwrap();
    slurm.told(here, "scontrol", &["update", &format!("JobId={job}"), "EndTime=now"]);
    wait_for("the time of the job is over", || elements(&slurm.status(here, "study")) == 0);
    let status = slurm.status(here, "study");
    assert_eq!(count(&status, "lost"), 2, "{status}");
    assert!(status.to_string().contains("DUE TO TIME LIMIT"), "{status}");
    let record: Value = json(&fs::read_to_string(run.join("run.json")).unwrap());
    assert_eq!(record["status"], "interrupted", "{record}");
    // The commands of the page: now with as many runs as the time of a job holds, as pilot runs here find it.
    let block = PAGE.split_once("```sh\n").unwrap().1.split_once("```").unwrap().0;
    let told: Vec<Output> = block.lines().map(|line| slurm.command(here, "sh", &["-c", line])).collect();
    assert!(told.iter().all(|output| output.status.success()), "{told:?}");
    let submitted = stderr(&told[0]);
    assert!(
        submitted.contains("pilot runs") && submitted.contains("2 runs were submitted in 1 elements"),
        "{submitted}"
    );
    assert!(stdout(&told[1]).contains("elements queued"), "{}", stdout(&told[1]));
}

/// A job is cancelled, the node is lost, and the limits of the cluster are kept.
fn cancelled_lost_and_throttled(slurm: &Slurm, here: &Path) {
    let command = submission(&["--per-task", "6", "--time", "5 min"]);
    let told = stderr(&slurm.granum(here, &command));
    assert!(told.contains("there is no room at present (MaxSubmitJobs = 12)"), "{told}");
    let status = slurm.status(here, "study");
    // The long campaign has an element as well.
    assert!((7..=12).contains(&elements(&status)), "{status}");
    assert!(
        status["jobs"].as_array().unwrap().len() >= 3,
        "arrays of at most eight elements, and one for samples: {status}"
    );
    assert!(
        count(&status, "queued") + count(&status, "running") > 30 && count(&status, "not begun") > 20,
        "{status}"
    );
    let told = stdout(&slurm.granum(here, &["campaign", "status", "study"]));
    assert!(told.contains("given to a scheduler") && told.contains("elements queued"), "{told}");
    let script = fs::read_to_string(here.join("study/jobs/0001.sh")).unwrap();
    assert!(script.starts_with("#!/bin/sh\nexec ") && !script.contains(here.to_str().unwrap()), "{script}");
    // Neither twice there nor here at the same time.
    slurm.granum(here, &command);
    assert!(elements(&slurm.status(here, "study")) <= 12);
    let mut given = BTreeSet::new();
    for entry in fs::read_dir(here.join("study/jobs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "json") {
            let record = json(&fs::read_to_string(path).unwrap());
            for run in
                record["elements"].as_array().unwrap().iter().flat_map(|element| element.as_array().unwrap())
            {
                assert!(given.insert(run.as_str().unwrap().to_string()), "{run} was given to Slurm twice");
            }
        }
    }
    let output =
        slurm.command(here, env!("CARGO_BIN_EXE_granum"), &["campaign", "plan.toml", "--out", "study"]);
    assert!(
        stderr(&output).contains("elements of jobs of this campaign are queued or go on"),
        "{}",
        stderr(&output)
    );

    // The last job is cancelled by Slurm's own command, then all of them when the node has lost its power.
    let job = status["jobs"].as_array().unwrap().last().unwrap()["job"].as_str().unwrap().to_string();
    slurm.told(here, "scancel", &[&job]);
    wait_for("runs go on", || count(&slurm.status(here, "study"), "running") > 0);
    slurm.make("node-off");
    slurm.make("node-on");
    // Slurm lets jobs wait for two minutes that lost their node.
    let requeue = || {
        let queue = slurm.told(here, "squeue", &["--me", "--noheader", "--array", "--format=%i %r"]);
        for line in queue.lines().filter(|line| line.ends_with("BeginTime")) {
            let job = line.split(' ').next().unwrap();
            slurm.command(here, "scontrol", &["update", &format!("JobId={job}"), "StartTime=now"]);
        }
    };
    let mut seen: BTreeMap<String, u64> = BTreeMap::new();
    wait_for("the jobs end", || {
        requeue();
        let status = slurm.status(here, "study");
        for word in ["queued", "running", "lost"] {
            let most = seen.entry(word.into()).or_default();
            *most = (*most).max(count(&status, word));
        }
        elements(&status) == 0
    });
    assert!(seen.values().all(|most| *most > 0), "{seen:?}");

    // `granum campaign cancel` ends what is queued; the same command, as often as there is no room for all, brings all to an end.
    slurm.granum(here, &command);
    let told = stdout(&slurm.granum(here, &["campaign", "cancel", "study"]));
    assert!(told.contains("was asked to end"), "{told}");
    let mut rounds = 0;
    wait_for("all runs are finished", || {
        requeue();
        let status = slurm.status(here, "study");
        if status["done"] == true {
            return true;
        }
        if elements(&status) < 4 {
            rounds += 1;
            slurm.granum(here, &command);
        }
        false
    });
    let long = &here.join("long");
    wait_for("the long campaign is finished", || {
        requeue();
        slurm.status(long, "study")["done"] == true
    });
    for here in [here, long] {
        let output = slurm.granum(here, &["--json", "campaign", "plan.toml", "--out", "study", "--collect"]);
        assert!(stderr(&output).is_empty(), "{}", stderr(&output));
        let status = slurm.status(here, "study");
        assert_eq!(status["jobs"].as_array().unwrap().len(), 0, "{status}");
    }
    assert!(rounds > 0);
}
