//! What a test says of its material: pore pressure, q, liquefaction, strength, scatter and the critical state line.

use std::path::Path;

use serde_json::Value;

use super::{done, done_json};

/// A ready case with few grains, fast.
const FEW: [&str; 8] = [
    "--set",
    "grains.count=120",
    "--set",
    "preparation.inertial_number=1e-2",
    "--set",
    "preparation.unbalanced_force=2e-2",
    "--set",
    "stage.1.inertial_number=5e-3",
];

fn run(here: &Path, case: &str, out: &str, more: &[&str]) -> Value {
    let file = format!("{case}.toml");
    if !here.join(&file).exists() {
        done(here, &["init", "--case", case, &file]);
    }
    done_json(here, &[&["run", &file, "--out", out], &FEW[..], more].concat())
}

fn measure(told: &Value, name: &str) -> f64 {
    told["measures"][name].as_f64().unwrap_or_else(|| panic!("no {name} in {}", told["measures"]))
}

/// The figure of a report whose file name has this part.
fn figure(here: &Path, run: &str, part: &str) -> String {
    let files = std::fs::read_dir(here.join(run).join("figures")).unwrap();
    let found = files.map(|file| file.unwrap().path()).find(|path| path.to_string_lossy().contains(part));
    std::fs::read_to_string(found.unwrap_or_else(|| panic!("no figure {part}"))).unwrap()
}

/// The pore pressure of a ready case counts from the consolidated sample, and what is left without stress is no strength.
#[test]
fn a_sample_that_liquefies_says_so() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let short = ["--set", "stage.1.axial_strain=0.06", "--set", "stage.1.states=30"];
    let told = run(here, "undrained-loose", "loose", &short);
    assert_eq!(measure(&told, "liquefied"), 1.0);
    let ratio = measure(&told, "largest_pore_pressure_ratio");
    assert!((0.95..=1.001).contains(&ratio), "{ratio}");
    assert!((0.0..0.06).contains(&measure(&told, "axial_strain_at_liquefaction")));
    assert!((0.3..1.3).contains(&measure(&told, "peak_stress_ratio")));
    assert!(told["measures"]["critical_friction_angle"].is_null(), "{told}");
    done(here, &["report", "loose"]);
    // The axis goes from 0 to the 100 kPa of the consolidation; it went from -100 to 20.
    let pressure = figure(here, "loose", "pore-pressure");
    assert!(pressure.contains("(kPa)") && pressure.contains(">100<"), "{pressure}");
    assert!(!pressure.contains("\u{2212}80<") && !pressure.contains("\u{2212}100<"));
    let page = std::fs::read_to_string(here.join("loose/report.html")).unwrap();
    assert!(page.contains("strain at liquefaction") && page.contains("axial less the mean lateral stress"));
    // One unit for all stresses of a figure.
    let path = figure(here, "loose", "stress-path");
    assert!(path.contains("(kPa)") && !path.contains("(Pa)"), "{path}");
}

/// An undrained test ends at a stress, which is a result: its stage was not cut short, and its sample has liquefied.
#[test]
fn an_undrained_test_ends_at_a_stress() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    done(here, &["init", "--case", "undrained-loose", "undrained-loose.toml"]);
    let text = std::fs::read_to_string(here.join("undrained-loose.toml")).unwrap();
    let text = format!("{text}until = {{ mean_stress = \"4 kPa\" }}\n");
    std::fs::write(here.join("undrained-loose.toml"), text).unwrap();
    let summary = run(here, "undrained-loose", "loose", &["--set", "stage.1.states=100"]);
    let notes = summary["notes"].to_string();
    assert!(notes.contains("mean_stress reached 4000 Pa"), "{notes}");
    assert_eq!(measure(&summary, "liquefied"), 1.0);
    let end = &summary["stresses"][1]["end"];
    let reached = end["mean_stress"].as_f64().unwrap();
    assert!((3.0e3..=4.1e3).contains(&reached), "{end}");
    let cut = summary["quality"]
        .as_array()
        .unwrap()
        .iter()
        .find(|flag| flag["name"] == "stages_cut_short")
        .unwrap();
    assert_eq!(cut["passed"], true, "{cut}");
    assert!(
        std::fs::read_to_string(here.join("loose/case.toml"))
            .unwrap()
            .contains("until = { mean_stress = 4000 }")
    );
}

/// What a test must fail is told before it is run, by a run and by the dry run of a campaign.
#[test]
fn a_check_that_must_fail_is_told_before() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    done(here, &["init", "--case", "drained-loose", "sand.toml"]);
    let plan = |accept: &str| {
        format!(
            "case = \"sand.toml\"\n{accept}set = {{ \"grains.count\" = 50, \"stage.1.inertial_number\" = 1e-2 }}\n[design]\nkind = \"full-factorial\"\n\
             [[variable]]\nkey = \"grains.material.friction\"\nvalues = [0.3, 0.5]\n"
        )
    };
    std::fs::write(here.join("plan.toml"), plan("")).unwrap();
    let estimate = done_json(here, &["campaign", "plan.toml", "--dry-run", "--pilots", "0"]);
    let foreseen = estimate["foreseen_failures"].as_array().unwrap();
    assert_eq!(foreseen.len(), 2, "{estimate:#}");
    assert!(foreseen[0]["check"] == "inertial_number" && foreseen[0]["certain"] == true, "{estimate:#}");
    let warnings = estimate["warnings"].to_string();
    assert!(warnings.contains("2 of 2 runs will not pass their check of inertial number"), "{warnings}");
    assert!(warnings.contains("left out of the data set"), "{warnings}");
    std::fs::write(here.join("plan.toml"), plan("accept = [\"inertial_number < 0.02\"]\n")).unwrap();
    let estimate = done_json(here, &["campaign", "plan.toml", "--dry-run", "--pilots", "0"]);
    assert_eq!(estimate["foreseen_failures"], serde_json::json!([]), "the plan accepts it");
    let fast = [
        "run",
        "sand.toml",
        "--set",
        "grains.count=50",
        "--set",
        "stage.1.inertial_number=1e-2",
        "--set",
        "stage.1.axial_strain=0.002",
        "--set",
        "preparation.unbalanced_force=5e-2",
        "--set",
        "preparation.inertial_number=1e-2",
        "--out",
        "fast",
    ];
    let output = super::common::run(here, &fast);
    let text = super::common::stderr(&output);
    assert!(text.contains("will not pass its check of inertial number"), "{text}");
}

/// Cycles to liquefaction, and no complaint about a servo that had nothing left to hold.
#[test]
fn a_cyclic_test_counts_its_cycles() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let told = run(here, "cyclic-undrained", "cycles", &["--set", "stage.1.cycles=20"]);
    assert_eq!(measure(&told, "liquefied"), 1.0, "{}", told["measures"]);
    let cycles = measure(&told, "cycles_to_liquefaction");
    assert!(cycles >= measure(&told, "cycles") && cycles <= 20.0, "{cycles}");
    assert!(measure(&told, "double_amplitude_axial_strain") > 1e-4);
    let text = told.to_string();
    assert!(text.contains("how well its stresses were held in per cent of p is not judged"), "{text}");
    let flags = told["quality"].as_array().unwrap();
    assert!(flags.iter().any(|flag| flag["name"] == "inertial_number"));
    // The stage of consolidation held its stresses, and is judged.
    let servo = flags.iter().find(|flag| flag["name"] == "servo_error_largest").unwrap();
    assert!(servo["value"].as_f64().unwrap() < 0.03, "{servo}");
}

/// Extension has a negative q, and two seeds a scatter; two stresses make a critical state line.
#[test]
fn strength_has_a_sign_a_scatter_and_a_line() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let short = ["--set", "stage.1.states=40", "--set", "stage.1.axial_strain=0.15"];
    let back = ["--set", "stage.1.states=40", "--set", "stage.1.axial_strain=-0.06"];
    let told = run(here, "drained-loose", "extension", &back);
    let series = done_json(here, &["export", "extension", "-o", "series.csv"]);
    assert!(measure(&told, "peak_stress_ratio") < -0.3, "{told} {series}");
    let angle = measure(&told, "peak_friction_angle");
    assert!((10.0..50.0).contains(&angle), "{angle}");
    for (name, more) in [
        ("one", &["--set", "preparation.seed=1"][..]),
        ("two", &["--set", "preparation.seed=2"][..]),
        ("high", &["--set", "stage.1.lateral_stress=400 kPa"][..]),
    ] {
        let told = run(here, "drained-loose", name, &[&short[..], more].concat());
        assert!(measure(&told, "peak_stress_ratio") > 0.5 && measure(&told, "critical_void_ratio") > 0.3);
        assert!(told["measures"]["critical_void_ratio_drift"].is_f64(), "{told}");
    }
    let told = done_json(here, &["compare", "one", "two", "high", "-o", "runs.svg"]);
    let rows = told["strength"].as_array().unwrap();
    assert_eq!(rows.len(), 5, "{told}");
    let angles: Vec<f64> = rows.iter().map(|row| row["peak_friction_angle"].as_f64().unwrap()).collect();
    assert!((angles[3] - 0.5 * (angles[0] + angles[1])).abs() < 1e-9, "{angles:?}");
    assert!((angles[4] - (angles[0] - angles[1]).abs() / 2f64.sqrt()).abs() < 1e-9, "{angles:?}");
    // These runs are too fast for their checks, so that they make no line, and each is named with the reason.
    assert!(told["critical_state_line"].is_null(), "{told}");
    let left_out = told["not_in_critical_state_line"].as_array().unwrap();
    assert_eq!(left_out.len(), 3, "{told}");
    assert!(left_out.iter().all(|run| run["reason"].as_str().unwrap().contains("inertial number")), "{told}");
    assert_eq!(told["materials_differ_in"], serde_json::json!([]));
    let drawn = std::fs::read_to_string(here.join("runs.svg")).unwrap();
    assert!(drawn.contains("not critical, or checks not passed") && !drawn.contains(">critical states<"));
    let text = done(here, &["compare", "one", "two", "high", "-o", "again.svg"]);
    assert!(text.contains("no critical state line") && text.contains("left out:"), "{text}");
    // Tests of two materials have no line in common.
    run(here, "drained-loose", "smooth", &[&short[..], &["--set", "grains.material.friction=0.1"]].concat());
    let told = done_json(here, &["compare", "one", "high", "smooth", "-o", "materials.svg"]);
    assert_eq!(told["materials_differ_in"], serde_json::json!(["grains.material.friction"]));
    assert!(told["critical_state_line"].is_null(), "{told}");
    done(here, &["report", "one", "two", "high", "--out", "together"]);
    let page = std::fs::read_to_string(here.join("together/report.html")).unwrap();
    assert!(page.contains("Critical state line") && page.contains("standard deviation"));
}
