//! Samples and tests: prepare, shear, report, digest, status, interrupt, resume; forces of the packing in `data`.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{run, stderr};
use crate::{SMALL, digest, done, done_json, refused};

#[test]
fn a_small_case_from_sample_to_report_and_one_digest_on_any_hardware() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    // The portable instructions are slow.
    std::fs::write(here.join("case.toml"), SMALL.replace("count = 150", "count = 60")).unwrap();
    let sample = done_json(here, &["prepare", "case.toml", "--out", "sample"]);
    assert_eq!(sample["status"], "finished");
    let solid_fraction = sample["measures"]["solid_fraction"].as_f64().unwrap();
    assert!((0.55..0.66).contains(&solid_fraction), "{solid_fraction}");
    assert!(done(here, &["status", "sample"]).contains("granum run CASE --sample sample"));

    done(here, &["shear", "case.toml", "--sample", "sample", "--out", "two"]);
    done(here, &["shear", "case.toml", "--out", "one", "--isa", "portable", "--threads", "2"]);
    assert_eq!(digest(here, "one"), digest(here, "two"));
    assert_ne!(digest(here, "sample"), digest(here, "two"));
    let status = done_json(here, &["status", "one"]);
    assert_eq!(status["status"], "finished");
    assert!((status["deviator_strain"].as_f64().unwrap() - 0.02).abs() < 2e-3, "{status}");

    let message = refused(here, 1, &["shear", "case.toml", "--out", "one"]);
    assert!(
        message.contains("one already contains a finished test; to continue from that: `granum report one`"),
        "{message}"
    );
    let message = refused(here, 1, &["train", "sample", "--out", "study"]);
    assert!(message.contains("sample: this is a sample, not a test"), "{message}");

    reports(here);
}

/// Reports of a run: in its folder, or as a single page elsewhere, but never over an existing one.
fn reports(here: &Path) {
    let told = done_json(here, &["report", "one"]);
    let files = std::fs::read_dir(here.join("one/figures")).unwrap().map(|entry| entry.unwrap().path());
    let figures = files.filter(|file| file.extension().is_some_and(|extension| extension == "svg")).count();
    assert!(figures >= 6 && told["figure_files"] == figures, "{told}");
    let page = std::fs::read_to_string(here.join("one/report.html")).unwrap();
    assert!(page.contains("60 grains") && page.contains("<svg"), "{}", page.len());
    for words in ["The paper", "the paper", "paper\u{2019}s", "We chose"] {
        assert!(!page.contains(words), "a run's own report says {words:?}");
    }
    // The report shows the same gap of the energy balance as the quality check.
    let gap = page
        .split("Energy balance, residual over boundary work")
        .nth(1)
        .and_then(|rest| rest.split("<b>").nth(1));
    let gap = gap.and_then(|rest| rest.split("</b>").next()).unwrap();
    assert!(page.contains(&format!("the energy balance closes to within {gap} of that work")), "{gap}");
    let message = refused(here, 1, &["report", "one"]);
    assert!(message.contains("report.html exists already"), "{message}");
    done(here, &["report", "one", "--force"]);
    done(here, &["report", "two", "--out", "two.html"]);
    assert!(here.join("two.html").is_file() && !here.join("two/report.html").exists());
    let message = refused(here, 1, &["report", "nowhere"]);
    assert!(message.contains("nowhere: there is no such file or folder"), "{message}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_tells_how_to_go_on_and_ends_in_the_same_bits() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL.replace("deviator_strain = 0.02", "deviator_strain = 0.06"))
        .unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let shear = |out| ["shear", "case.toml", "--sample", "sample", "--out", out];
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(shear("broken"))
        .current_dir(here)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    // The record follows the first checkpoint.
    while !here.join("broken/checkpoint").exists() || !here.join("broken/run.json").exists() {
        assert!(started.elapsed() < Duration::from_secs(30), "the test did not begin");
        sleep(Duration::from_millis(2));
    }
    assert_eq!(done_json(here, &["status", "broken"])["status"], "running");
    let message = refused(here, 1, &["resume", "broken"]);
    assert!(message.contains("in use by another granum process"), "{message}");
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130), "{}", stderr(&ended));
    assert!(stderr(&ended).contains("continue with `granum resume broken`"), "{}", stderr(&ended));

    let status = done_json(here, &["status", "broken"]);
    assert_eq!(status["status"], "interrupted");
    assert_eq!(status["next"], "continue it: granum resume broken");
    let half = run(here, &["digest", "broken"]);
    assert!(String::from_utf8_lossy(&half.stdout).contains("of the part finished so far"));
    done(here, &["resume", "broken"]);
    done(here, &shear("straight"));
    assert_eq!(digest(here, "broken"), digest(here, "straight"));
}

#[test]
fn more_threads_than_processors_are_not_taken_and_no_speed_is_told_before_it_is_known() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    let output = run(here, &["shear", "case.toml", "--threads", "1000", "--checkpoint-every", "0.1"]);
    let told = stderr(&output);
    assert!(output.status.success() && told.contains("warning: --threads 1000: this machine has"), "{told}");
    assert!(told.contains("solid fraction") && !told.contains(" 0.0 M") && !told.contains(" 0 k"), "{told}");
    let record = granum_io::Run::at(here.join("run")).unwrap().record().unwrap();
    assert_eq!(record.machine.threads, record.machine.available_threads);
    let output = run(here, &["--json", "prepare", "case.toml", "--threads", "1000"]);
    let told = crate::common::json(&crate::common::stdout(&output));
    assert!(told["warnings"][0].as_str().unwrap().contains("results do not depend on it"), "{told}");
}

#[test]
fn forces_of_the_shipped_packing_are_those_known() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let packing = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/packing-5000.csv");
    let told = done_json(here, &["forces", packing, "--normal", "hertz", "-o", "forces.csv"]);
    let mean_stress = told["mean_stress"].as_f64().unwrap();
    assert!((mean_stress - 20000.025).abs() < 0.01, "{mean_stress}");
    let table = granum_io::read_table(here.join("forces.csv")).unwrap();
    let whole = done_json(here, &["forces", packing, "--normal", "hertz"]);
    assert_eq!(whole["forces"]["id"][4], 5);
    for name in ["fx", "tz"] {
        let values: Vec<f64> = serde_json::from_value(whole["forces"][name].clone()).unwrap();
        assert_eq!(values, table.column(name).unwrap());
    }
    assert_eq!(table.rows(), 5000);
    for name in ["tx", "ty", "tz"] {
        assert!(table.column(name).unwrap().iter().all(|torque| *torque == 0.0), "{name}");
    }
    // Contact forces are typically 1e-4 N, and their sum vanishes, since action and reaction cancel.
    for name in ["fx", "fy", "fz"] {
        let sum: f64 = table.column(name).unwrap().iter().sum();
        assert!(sum.abs() < 1e-15, "{name} {sum}");
    }
    let message = refused(here, 1, &["forces", packing, "--normal", "hertz", "-o", "forces.csv"]);
    assert!(message.contains("forces.csv exists already"), "{message}");
}

/// The normal load falls while the shear is held: the force follows the loading curve, to the digits of an independent integration of
/// `dT = (1 - theta) mu dN`.
#[test]
fn a_pair_that_is_unloaded_at_held_shear_stays_on_its_curve() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    for (approach, right) in [("5e-9", 1.896e-5), ("9e-9", 2.7625e-5)] {
        let rows = format!("normal_approach,tangential_displacement\n1e-8,0\n1e-8,1e-9\n{approach},1e-9\n");
        std::fs::write(place.join("held.csv"), rows).unwrap();
        let law = ["--normal", "hertz", "--tangential", "mindlin-deresiewicz", "--friction", "0.3"];
        let printed = done(place, &[&["pair", "held.csv", "--diameter", "0.1 mm"], &law[..]].concat());
        let last = printed.lines().last().unwrap();
        let force: f64 = last.split(',').nth(3).unwrap().parse().unwrap();
        assert!((force / right - 1.0).abs() < 1e-4, "{last}");
    }
}
