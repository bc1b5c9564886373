//! A test that is followed while it runs: its states are on the disk as soon as they are recorded.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{json, run, stderr, stdout};
use crate::{assert_same, done};

/// A test of stages with a histogram of its own, long enough to be killed in its midst.
const CASE: &str = r#"
[grains]
count = 120
[grains.material]
interface_energy = 0
[contact]
normal = "hertz"
tangential = "no-slip"
[preparation]
solid_fraction = "none"
friction = 0.1
inertial_number = 1e-2
unbalanced_force = 2e-2
[recording]
observations_per_state = 3
sensors = ["overlap_distribution"]
[[stage]]
path = "drained-triaxial"
axial_strain = 0.05
inertial_number = 2e-3
states = 40
[[stage]]
path = "drained-triaxial"
axial_strain = 0.005
inertial_number = 5e-3
states = 3
"#;

/// Ends the process when the test ends, also if it fails.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn begin(here: &Path) -> Running {
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(["run", "case.toml", "--out", "run", "--threads", "1"])
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    Running(child.unwrap())
}

/// The lines of the states so far.
fn lines(here: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(here.join("run/states.jsonl")).unwrap_or_default();
    text.lines().map(str::to_string).collect()
}

/// The states in a table that is exported of the run.
fn exported(here: &Path, table: &str, file: &str) -> granum_core::Table {
    let output = run(here, &["--force", "export", "run", "--table", table, "-o", file]);
    assert!(output.status.success(), "{}", stderr(&output));
    granum_io::read_table(here.join(file)).unwrap()
}

#[test]
fn a_test_is_seen_while_it_runs_and_ends_in_the_same_bytes() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), CASE).unwrap();
    done(here, &["run", "case.toml", "--out", "straight"]);
    assert!(!here.join("straight/states.jsonl").exists());

    // No checkpoint falls into the test, whose tables are thus not written before its end.
    let running = begin(here);
    let started = Instant::now();
    while lines(here).len() < 6 {
        assert!(started.elapsed() < Duration::from_secs(60), "no states");
        std::thread::sleep(Duration::from_millis(2));
    }
    let status = json(&stdout(&run(here, &["--json", "status", "run"])));
    assert_eq!(status["status"], "running");
    assert!(status["states"].as_u64().unwrap() >= 6, "{status}");
    drop(running);

    // Each line is a state: what a notebook reads is what is exported, and what the test ends with.
    let told = lines(here);
    let whole: Vec<serde_json::Value> = told.iter().map(|line| json(line)).collect();
    assert!(whole.len() < 41, "the test was to be killed before its end");
    let series = exported(here, "series", "series.csv");
    let straight = granum_io::read_table(here.join("straight/series.parquet")).unwrap();
    assert_eq!(series.rows(), whole.len());
    for name in ["stage", "state", "axial_strain", "mean_stress", "overlaps_above"] {
        let values = series.column(name).unwrap();
        assert_eq!(values, &straight.column(name).unwrap()[..values.len()], "{name}");
        let lines: Vec<f64> = whole.iter().map(|line| line[name].as_f64().unwrap()).collect();
        assert_eq!(values, lines, "{name}");
    }
    for table in ["forces", "overlaps"] {
        let counts = exported(here, table, "histogram.csv");
        let file = if table == "forces" { "forces.parquet" } else { "histograms/overlaps.parquet" };
        let all = granum_io::read_table(here.join("straight").join(file)).unwrap();
        let values = counts.column("count").unwrap();
        assert!(!values.is_empty());
        assert_eq!(values, &all.column("count").unwrap()[..values.len()], "{table}");
    }
    let status = stdout(&run(here, &["status", "run"]));
    assert!(
        status.contains("test killed") && status.contains(&format!("{} states recorded", whole.len())),
        "{status}"
    );
    done(here, &["report", "run"]);
    std::fs::remove_file(here.join("run/report.html")).unwrap();
    let _ = std::fs::remove_dir_all(here.join("run/figures"));

    // The line on which the process was killed is passed over; the resumed test writes all states again.
    let text = told.join("\n") + "\n";
    std::fs::write(here.join("run/states.jsonl"), &text[..text.len() - 30]).unwrap();
    assert_eq!(exported(here, "series", "torn.csv").rows(), whole.len() - 1);
    done(here, &["resume", "run"]);
    assert!(!here.join("run/states.jsonl").exists());
    assert!(assert_same(&here.join("straight"), &here.join("run")) >= 10);
}
