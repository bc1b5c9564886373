//! Campaigns: a plan is checked, carried out, continued and changed, and nothing is lost.

use std::path::Path;
use std::process::Command;

use granum_io::OutputFolder;

use crate::common::{run, stderr, stdout};
use crate::{digest, done, done_json, refused};

/// A drained triaxial test that takes a tenth of a second.
const SAND: &str = "[grains]\ncount = 60\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\n\
                    tangential = 'no-slip'\n[preparation]\nmean_stress = '100 kPa'\nfriction = 0.1\nsolid_fraction = 'none'\n\
                    inertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.01\n\
                    inertial_number = 1e-2\nstates = 4\n";

/// Four runs of two frictions and two stages, so that each of two samples serves two tests.
const PLAN: &str = "case = 'sand.toml'\n[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'friction'\n\
                    keys = ['grains.material.friction']\nvalues = [0.2, 0.4]\n[[variable]]\nname = 'strain'\n\
                    key = 'stage.1.axial_strain'\nvalues = ['1 %', '1.5 %']\n";

pub fn folder_with_plan() -> tempfile::TempDir {
    let base = tempfile::tempdir().unwrap();
    std::fs::write(base.path().join("sand.toml"), SAND).unwrap();
    std::fs::write(base.path().join("plan.toml"), PLAN).unwrap();
    base
}

fn change(here: &Path, from: &str, to: &str) {
    let plan = std::fs::read_to_string(here.join("plan.toml")).unwrap();
    assert!(plan.contains(from));
    std::fs::write(here.join("plan.toml"), plan.replace(from, to)).unwrap();
}

fn names(status: &serde_json::Value) -> Vec<String> {
    status["runs"].as_array().unwrap().iter().map(|run| run["name"].as_str().unwrap().to_string()).collect()
}

#[test]
fn a_plan_is_checked_as_a_whole_before_anything_runs() {
    let base = folder_with_plan();
    let here = base.path();
    let told = done(here, &["campaign", "plan.toml", "--dry-run", "--pilots", "0"]);
    assert!(
        told.starts_with("4 runs: all combinations of sand.toml") && told.contains("1 %, 1.5 %"),
        "{told}"
    );
    assert!(!told.contains("estimate"), "{told}");
    let all = done_json(here, &["campaign", "plan.toml", "--dry-run", "--pilots", "2"]);
    let estimate = &all["estimate"];
    assert_eq!(estimate["pilots"].as_array().unwrap().len(), 2, "{estimate}");
    assert!(
        estimate["pilots"].as_array().unwrap().iter().all(|pilot| pilot["finished"] == true),
        "{estimate}"
    );
    let [least, mean, most] =
        [&estimate["seconds_between"][0], &estimate["seconds"], &estimate["seconds_between"][1]]
            .map(|seconds| seconds.as_f64().unwrap());
    assert!(0.0 < least && least <= mean && mean <= most && most < 60.0, "{estimate}");
    assert!(estimate["disk_bytes"].as_f64().unwrap() > 1e4, "{estimate}");
    assert!(!cfg!(target_os = "linux") || estimate["memory_bytes"].as_u64().unwrap() > 1 << 20, "{estimate}");
    assert_eq!(std::fs::read_dir(here).unwrap().count(), 2, "nothing was written");
    assert_eq!(all["runs"][3]["values"]["strain"], 0.015);
    assert_eq!(all["runs"][3]["settings"]["stage.1.axial_strain"], "1.5 %");

    // A corner that no case accepts is refused with its place and its values.
    change(here, "[0.2, 0.4]", "[0.2, 40]");
    let told = refused(here, 1, &["campaign", "plan.toml"]);
    assert!(told.contains("plan.toml:4:") && told.contains("friction = \"40\""), "{told}");
    assert!(told.contains("in the run with friction = 40, strain = 0.01"), "{told}");
    change(here, "40]", "0.4]");
    change(here, "case =", "engine = 'lamps'\ncase =");
    let told = refused(here, 1, &["campaign", "plan.toml", "--dry-run"]);
    assert!(told.contains("there is no engine \"lamps\"; did you mean lammps?"), "{told}");
    change(here, "engine = 'lamps'\ncase =", "case =");
    change(here, "material.friction", "material.frictoin");
    let told = refused(here, 1, &["campaign", "plan.toml"]);
    assert!(
        told.contains("plan.toml:6:") && told.contains("did you mean grains.material.friction?"),
        "{told}"
    );
    let told = refused(here, 1, &["campaign", "plan.toml", "--workers", "0"]);
    assert!(told.contains("is not a key"), "{told}");
    assert!(!here.join("plan").exists());
}

#[test]
fn a_campaign_is_carried_out_continued_and_changed() {
    let base = folder_with_plan();
    let here = base.path();
    let told = done_json(here, &["campaign", "plan.toml", "--out", "study", "--workers", "2"]);
    assert_eq!((&told["finished"], &told["reused"], &told["stopped"]), (&4.into(), &0.into(), &false.into()));
    let status = done_json(here, &["campaign", "status", "study"]);
    assert_eq!((&status["done"], &status["at_work"]), (&true.into(), &false.into()));
    let runs = names(&status);
    assert_eq!(
        std::fs::read_dir(here.join("study/samples")).unwrap().count(),
        2,
        "a sample for each friction"
    );

    // The runs are flagged, since the tests are far too fast, and not part of the data set.
    assert_eq!(told["refused"], 4);
    assert_eq!(status["runs"][0]["accepted"], false);
    assert_eq!(status["runs"][0]["failed_checks"][0]["name"], "inertial_number");

    // A run of the campaign is the run that a user would have made alone.
    let alone = [
        "run",
        "sand.toml",
        "--set",
        "grains.material.friction=0.4",
        "--set",
        "stage.1.axial_strain=1.5 %",
        "--out=alone",
    ];
    done(here, &alone);
    assert_eq!(digest(here, "alone"), digest(here, &format!("study/tests/{}", runs[3])));

    // The same command has nothing left to do, also after its journal and even its list of runs were lost.
    let told = done(here, &["campaign", "plan.toml", "--out", "study"]);
    assert!(told.contains("all were already finished"), "{told}");
    std::fs::remove_file(here.join("study/journal.jsonl")).unwrap();
    assert_eq!(done_json(here, &["campaign", "status", "study"])["runs"], status["runs"]);
    std::fs::remove_file(here.join("study/campaign.json")).unwrap();
    let told = done_json(here, &["campaign", "plan.toml", "--out", "study"]);
    assert_eq!((&told["finished"], &told["reused"]), (&4.into(), &6.into()));
    assert_eq!(done_json(here, &["status", "study"])["runs"], status["runs"]);
    done(here, &["resume", "study"]);
    let table = done_json(here, &["table", "study"]);
    assert_eq!(names(&table), runs, "in the order of the plan");

    the_report(here);
    a_changed_plan(here, &runs);
    a_folder_in_use(here);
}

/// The report has the curves of all runs, coloured by a variable.
fn the_report(here: &Path) {
    let told = done_json(here, &["report", "study", "--colour", "strain"]);
    assert!(told["figure_files"].as_u64().unwrap() >= 3, "{told}");
    let page = std::fs::read_to_string(here.join("study/report.html")).unwrap();
    assert!(page.contains("Campaign of 4 runs") && page.contains("coloured by strain"));
    let told = refused(here, 1, &["--force", "report", "study", "--colour", "strian"]);
    assert!(told.contains("the campaign has no such variable; did you mean strain?"), "{told}");
    let told = refused(here, 1, &["--force", "report", "alone", "--colour", "strain"]);
    assert!(told.contains("it belongs to the report of a campaign"), "{told}");
}

/// Runs that are still in the plan are kept, and nothing is thrown away without --force.
fn a_changed_plan(here: &Path, before: &[String]) {
    change(here, "'1 %', '1.5 %'", "'1.5 %', '2 %'");
    change(
        here,
        "case =",
        "accept = ['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', \
            'unbalanced_force < 10', 'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1']\ncase =",
    );
    let output = run(here, &["campaign", "plan.toml", "--out", "study"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let told = stderr(&output);
    assert!(told.contains("2 runs are still in it, 2 are new, 2 are no longer in it"), "{told}");
    assert!(told.contains("stay and are not used") && told.contains(&before[0]), "{told}");
    let status = done_json(here, &["campaign", "status", "study"]);
    assert_eq!(status["no_longer_planned"].as_array().unwrap().len(), 2);
    assert_eq!(status["runs"][0]["name"], before[1].as_str());
    assert_eq!(status["counts"]["flagged, accepted"], 4, "{status}");
    assert!(here.join("study/tests").join(&before[0]).is_dir());
    assert_eq!(names(&done_json(here, &["table", "study"])).len(), 4);
    done(here, &["--force", "campaign", "plan.toml", "--out", "study"]);
    assert!(!here.join("study/tests").join(&before[0]).exists());
    assert!(here.join("study/tests").join(&before[1]).is_dir());
}

/// A second coordinator is refused.
fn a_folder_in_use(here: &Path) {
    let held = OutputFolder::open(here.join("study")).unwrap();
    let told = refused(here, 1, &["campaign", "plan.toml", "--out", "study"]);
    assert!(told.contains("study is in use by another granum process"), "{told}");
    assert_eq!(done_json(here, &["campaign", "status", "study"])["at_work"], true);
    drop(held);
    // A folder of another kind is not taken over.
    let told = refused(here, 1, &["campaign", "plan.toml", "--out", "alone"]);
    assert!(told.contains("alone already contains a finished test"), "{told}");
}

/// A run that cannot write its files is tried again, kept with its reason, and goes on when there is room again.
#[cfg(unix)]
#[test]
fn a_full_disk_costs_no_other_run() {
    let base = folder_with_plan();
    let here = base.path();
    let script = "trap '' XFSZ; ulimit -f 32; exec \"$0\" campaign plan.toml --out study";
    let output = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_granum")])
        .current_dir(here)
        .output()
        .unwrap();
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("it is tried again") && told.contains("(tried 2 times)"), "{told}");
    assert!(told.contains("of 4 runs failed") && told.contains("cannot write"), "{told}");
    let status = done_json(here, &["campaign", "status", "study"]);
    assert_eq!(status["counts"]["failed"], 4, "{status}");
    assert!(status["runs"][0]["reason"].as_str().unwrap().contains("failed"), "{status}");
    done(here, &["campaign", "plan.toml", "--out", "study"]);
    assert_eq!(done_json(here, &["campaign", "status", "study"])["counts"]["flagged"], 4);
}

/// A run that fails because of its case fails alone, with its reason, and is not tried again without need.
#[test]
fn a_run_that_fails_by_its_case_is_kept_with_its_reason() {
    let base = folder_with_plan();
    let here = base.path();
    // Grains that are placed at random never fill half of the space.
    change(
        here,
        "name = 'strain'\nkey = 'stage.1.axial_strain'\nvalues = ['1 %', '1.5 %']",
        "name = 'initial'\nkey = 'preparation.initial_solid_fraction'\nvalues = [0.3, 0.5]",
    );
    let output = run(here, &["campaign", "plan.toml", "--out", "study"]);
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("2 of 4 runs failed") && !told.contains("tried again"), "{told}");
    let status = done_json(here, &["campaign", "status", "study"]);
    assert_eq!((&status["counts"]["failed"], &status["counts"]["flagged"]), (&2.into(), &2.into()));
    let reason = status["runs"][1]["reason"].as_str().unwrap();
    assert!(reason.contains("random placement reaches about 0.38"), "{reason}");
    // Again: the reasons are told again, and nothing is begun.
    let journal = || std::fs::read_to_string(here.join("study/journal.jsonl")).unwrap().lines().count();
    let lines = journal();
    let output = run(here, &["campaign", "plan.toml", "--out", "study"]);
    assert!(output.status.code() == Some(1) && stderr(&output).contains(reason), "{}", stderr(&output));
    assert!(stdout(&output).contains("2 of 4 runs finished, 2 failed"), "{}", stdout(&output));
    assert_eq!(journal(), lines);
}

/// The time is over before the runs are: they end in good order and go on later.
#[test]
fn a_campaign_stops_after_a_time_and_goes_on() {
    let base = folder_with_plan();
    let here = base.path();
    let told = done_json(here, &["campaign", "plan.toml", "--out", "study", "--stop-after", "0.2 s"]);
    assert_eq!(told["stopped"], true, "{told}");
    let told = done_json(here, &["resume", "study"]);
    assert_eq!((&told["stopped"], &told["finished"]), (&false.into(), &4.into()));
    let told = refused(here, 2, &["campaign", "plan.toml", "--stop-after", "5 weeks"]);
    assert!(told.contains("90 s, 30 min, 8 h or 2 d"), "{told}");
}

/// Each run can be executed by a command of its own, in any order; what they did is collected.
#[test]
fn the_runs_are_listed_as_commands_and_collected() {
    let base = folder_with_plan();
    let here = base.path();
    let listed = done(here, &["campaign", "plan.toml", "--out", "study", "--list-jobs"]);
    let jobs: Vec<Vec<&str>> = listed.lines().map(|line| line.split(' ').skip(1).collect()).collect();
    assert_eq!(jobs.len(), 4, "{listed}");
    // The last first, two of one sample at once, and one twice.
    std::thread::scope(|scope| {
        for job in [&jobs[3], &jobs[2], &jobs[2]] {
            scope.spawn(move || done(here, job));
        }
    });
    // What an earlier call noted of a run, of which another machine has made an end.
    let name = jobs[3].last().unwrap();
    let failed = format!(
        "{{\"time\":\"2026-11-24T09:30:00Z\",\"run\":\"{name}\",\"event\":\"failed\",\"reason\":\"x\",\"lasting\":true}}\n"
    );
    std::fs::write(here.join("study/journal.jsonl"), failed).unwrap();
    assert_eq!(done_json(here, &["campaign", "status", "study"])["counts"]["failed"], 0);
    let left = done(here, &["campaign", "plan.toml", "--out", "study", "--list-jobs"]);
    assert_eq!(left.lines().collect::<Vec<_>>(), listed.lines().take(2).collect::<Vec<_>>());
    let output = run(here, &["campaign", "plan.toml", "--out", "study", "--collect"]);
    let (told, noted) = (stdout(&output), stderr(&output));
    assert!(
        told.contains("2 flagged; 2 not begun") && noted.contains("2 more runs are finished"),
        "{told} {noted}"
    );
    let told = done_json(here, &["campaign", "plan.toml", "--out", "study"]);
    assert_eq!(told["finished"], 4);
    done(here, &["campaign", "plan.toml", "--out", "other"]);
    for name in names(&done_json(here, &["campaign", "status", "study"])) {
        assert_eq!(
            digest(here, &format!("study/tests/{name}")),
            digest(here, &format!("other/tests/{name}"))
        );
    }
}

/// The plans of the gallery are read with their base cases.
#[test]
fn ready_plans_are_written_with_their_cases() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let list = done_json(here, &["init", "--list"]);
    for plan in list["plans"].as_array().unwrap() {
        let name = plan["name"].as_str().unwrap();
        assert!(plan["title"].as_str().unwrap().ends_with('.'), "{plan}");
        let told = done(here, &["init", "--plan", name]);
        let command = told.lines().next_back().unwrap().rsplit_once("granum ").unwrap().1;
        let words: Vec<&str> = command.split(' ').chain(["--pilots", "0"]).collect();
        let runs = done_json(here, &words);
        // Long runs are few.
        let least = match name {
            "random-paths-cycles" => 4,
            "flow-function" => 9,
            "flow-function-limestone" => 2,
            _ => 40,
        };
        assert!(runs["runs"].as_array().unwrap().len() >= least, "{runs}");
    }
    let told = refused(here, 1, &["init", "--plan", "friction-pressure-density"]);
    assert!(told.contains("exists already"), "{told}");
    let told = refused(here, 1, &["init", "--plan", "friction-pressure"]);
    assert!(told.contains("did you mean friction-pressure-density?"), "{told}");
}
