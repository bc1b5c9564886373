//! The commands of the tutorial work exactly as they are printed.

use std::path::Path;

use crate::chapter::words;
use crate::{done, done_json, refused};

const TUTORIAL: &str = include_str!("../../../../docs/src/tutorial.md");

/// The code blocks of a language, in order.
fn blocks(language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let after = |text: &str| text.split("```").next().unwrap_or_default().to_string();
    TUTORIAL.split(&fence).skip(1).map(after).collect()
}

/// Writes the file of a block, which the tutorial must name.
fn write(here: &Path, name: &str, text: &str) {
    assert!(TUTORIAL.contains(&format!("`{name}`")), "{name} is not named");
    std::fs::write(here.join(name), text).unwrap();
}

/// What so small and fast runs do not pass.
const ACCEPT: &str = "accept = ['servo_error_rms < 1', 'servo_error_largest < 1', 'inertial_number < 1', 'unbalanced_force < 1', \
                      'largest_overlap < 0.5', 'mean_stress_lost < 1', 'energy_gap < 1', 'sample_unbalanced_force < 1', \
                      'sample_mean_stress_missed_by < 1', 'solid_fraction_missed_by < 1']\n";

#[test]
fn what_the_tutorial_says_works() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let [case, plan, triaxial, calibration] = &blocks("toml")[..] else { panic!("four blocks of TOML") };
    granum_io::Case::parse(case, "my-sand.toml").unwrap();
    // The same keys with fewer grains and less strain, to save time.
    let small = case
        .replace("count = 1000", "count = 150")
        .replace("deviator_strain = 0.1", "deviator_strain = 0.01")
        .replace("inertial_number = 1e-3", "inertial_number = 5e-3")
        .replace("inertial_number = 2e-3", "inertial_number = 5e-3");
    assert_ne!(&small, case);
    write(here, "my-sand.toml", &small);
    write(here, "my-study.toml", &format!("{ACCEPT}{plan}"));
    write(here, "triaxial.toml", triaxial);
    write(here, "my-calibration.toml", calibration);
    write(here, "lab.csv", &blocks("csv")[0]);
    let mut commands = 0;
    let sh = blocks("sh").concat().replace("\\\n", " ");
    for line in sh.lines() {
        let words = words(line);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        // A reproduction takes an hour, and a quick one minutes; it has its own tests.
        if words.first() != Some(&"granum") || words[1] == "reproduce" {
            continue;
        }
        commands += 1;
        match words[1] {
            "calibrate" => truth_is_within_the_intervals(&done_json(here, &words[1..])),
            _ => drop(done(here, &words[1..])),
        }
    }
    assert!(commands >= 15, "{commands} commands");
    for file in
        ["run-1/report.html", "run-2/run.json", "study/report.html", "study.csv", "sand.svg", "mean.svg"]
    {
        assert!(here.join(file).is_file(), "{file}");
    }

    // The statement of the block about complete case files holds: a key may occur only once.
    let both = std::fs::read_to_string(here.join("every-key.toml")).unwrap() + case;
    std::fs::write(here.join("both.toml"), both).unwrap();
    let message = refused(here, 1, &["shear", "both.toml", "--out", "no"]);
    assert!(message.contains("duplicate key"), "{message}");
}

/// The intervals of the calibration hold the friction and the modulus with which the curves were made.
fn truth_is_within_the_intervals(calibration: &serde_json::Value) {
    for (k, (name, truth)) in [("friction", 0.35), ("modulus", 3e9)].into_iter().enumerate() {
        let parameter = &calibration["parameters"][k];
        assert_eq!(parameter["name"], name, "{calibration:#}");
        let [low, high] = ["quantile_5", "quantile_95"].map(|key| parameter[key].as_f64().unwrap());
        assert!(low < truth && truth < high, "{name}: {low} {truth} {high}");
    }
}
