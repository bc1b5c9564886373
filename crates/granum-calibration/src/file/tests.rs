//! What a file says, and what is refused of it, with its place.

use std::sync::Arc;

use granum_campaign::plan::PlanSource;
use granum_io::{Error, Reading};

use super::*;
use crate::compared::quantity::Quantity;
use crate::inference::prior::Prior;

/// A base case for tests of other files.
pub(crate) const PLAIN_CASE: &str = "[grains]\ncount = 200\n[preparation]\nmean_stress = \"100 kPa\"\n[[stage]]\npath = \"drained-triaxial\"\n\
                                     lateral_stress = \"100 kPa\"\naxial_strain = 0.2\n";
const CASE: &str = "[grains]\ncount = 200\n[preparation]\nmean_stress = \"100 kPa\"\nrelative_density = 0.5\n\
                    densest_void_ratio = 0.5\nloosest_void_ratio = 0.8\n[[stage]]\npath = \"drained-triaxial\"\n\
                    lateral_stress = \"100 kPa\"\naxial_strain = 0.2\n";
const FILE: &str = "case = \"sand.toml\"

[calibration]
tests = [\"A\", \"B\"]
runs = 24

[calibration.density]
densest_void_ratio = 0.6
loosest_void_ratio = 1.0

[[calibration.quantity]]
name = \"deviator_stress\"
to = \"10 %\"
absolute = \"2 kPa\"

[[variable]]
name = \"friction\"
key = \"grains.material.friction\"
prior = \"uniform\"
from = 0.2
to = 0.8

[[variable]]
name = \"stiffness\"
key = \"grains.material.youngs_modulus\"
prior = \"log-uniform\"
from = \"100 MPa\"
to = \"10 GPa\"

[[variable]]
name = \"lateral_stress\"
keys = [\"preparation.mean_stress\", \"stage.1.lateral_stress\"]
test = \"lateral_stress\"

[[variable]]
name = \"density\"
test = \"relative_density\"

[[variable]]
name = \"shift\"
prior = \"normal\"
mean = 0
deviation = 0.1
own = true

[[variable]]
name = \"relative_density\"
key = \"preparation.relative_density\"
expression = \"min(max(density + shift, 0), 1)\"
";

/// A file that compares the deviator stress, with the friction as its first variable; other variables may follow.
pub(crate) const STRESS_AND_FRICTION: &str = "case = \"sand.toml\"
[calibration]
[[calibration.quantity]]
name = \"deviator_stress\"
[[variable]]
name = \"friction\"
key = \"grains.material.friction\"
prior = \"uniform\"
from = 0.2
to = 0.8
";

/// A file of the plain case, which must have no mistake.
pub(crate) fn file(text: &str) -> CalibrationFile {
    parsed(text, PLAIN_CASE).unwrap_or_else(|error| panic!("{error}"))
}

/// A file with the text of its base case.
fn parsed(text: &str, case: &str) -> granum_io::Result<CalibrationFile> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sand.toml"), case).unwrap();
    let source =
        PlanSource { file: "material.toml".into(), folder: folder.path().into(), text: Arc::from(text) };
    CalibrationFile::parse(source, Reading::default())
}

#[test]
fn a_file_says_what_is_free_what_tests_give_and_what_is_compared() {
    let file = parsed(FILE, CASE).unwrap_or_else(|error| panic!("{error}"));
    let free: Vec<(&str, bool)> = file.free.iter().map(|free| (free.name.as_str(), free.own)).collect();
    assert_eq!(free, [("friction", false), ("stiffness", false), ("shift", true)]);
    assert_eq!(file.free[1].prior, Prior::LogUniform { from: 1e8, to: 1e10 });
    assert_eq!(file.free[1].unit, "Pa");
    assert_eq!(file.conditions[1], ("density".into(), TestCondition::RelativeDensity));
    let table = &file.calibration;
    assert_eq!((table.tests.as_slice(), table.runs), (&["A".to_string(), "B".to_string()][..], 24));
    assert_eq!((table.method, table.void_ratio_limits), (Method::Surrogate, Some([0.6, 1.0])));
    let compared = &table.quantities[0];
    assert_eq!((compared.strains.len(), compared.strains[0], compared.strains[15]), (16, 0.005, 0.1));
    assert_eq!((compared.error.absolute, compared.error.relative), (2e3, 0.02));
}

#[test]
fn mistakes_are_told_with_their_lines() {
    for (from, to, parts) in [
        ("runs = 24", "rums = 24", &["material.toml:5:", "\"rums\" is no key of a calibration", "runs"][..]),
        (
            "prior = \"log-uniform\"",
            "prior = \"lognormal\"",
            &["material.toml:26:", "lognormal", "log-uniform"],
        ),
        ("from = 0.2\nto = 0.8", "from = 0.9\nto = 0.8", &["material.toml:16:", "prior of friction", "0.9"]),
        ("deviation = 0.1\n", "", &["the prior of shift needs deviation"]),
        (
            "runs = 24",
            "runs = 24\nstress_scale = \"0 Pa\"",
            &["material.toml:6:", "stress_scale = 0 must be positive"],
        ),
        ("youngs_modulus", "young", &["material.toml:25:", "youngs_modulus"]),
        ("\"100 MPa\"", "\"100 mm\"", &["material.toml:27:", "100 mm", "length"]),
        ("test = \"lateral_stress\"", "test = \"pressure\"", &["material.toml:33:", "pressure"]),
        ("name = \"deviator_stress\"", "name = \"q\"", &["material.toml:12:", "q"]),
        ("to = \"10 %\"", "to = \"30 %\"", &["material.toml:11:", "30.0000 %", "stage.1.axial_strain"]),
        ("density + shift", "density + 0", &["the variable shift changes nothing"]),
        ("density + shift", "density + shirt", &["shirt is neither", "shift"]),
        (
            "[calibration.density]\ndensest_void_ratio = 0.6\nloosest_void_ratio = 1.0\n",
            "",
            &["[calibration.density]"],
        ),
        ("own = true", "own = 1", &["own must be true"]),
        (
            "runs = 24",
            "runs = 24\nmethod = \"dem\"\npredict = [\"C\"]",
            &["material.toml:7:", "predict needs a surrogate, since", "leave predict out"],
        ),
        ("runs = 24", "runs = 24\nmethod = \"abc\"", &["method = \"abc\"", "surrogate"]),
        (
            "runs = 24",
            "runs = 24\nsamples = 2",
            &["material.toml:6:", "samples is for method = \"dem\"", "leave it out"],
        ),
        ("test = \"relative_density\"", "test = \"relative_density\"\nfrom = 1", &["from belongs to"]),
    ] {
        assert!(FILE.contains(from), "{from}");
        let error = parsed(&FILE.replace(from, to), CASE).unwrap_err();
        let told = match &error {
            Error::Inputs(all) => all
                .iter()
                .map(|one| format!("{one} {}", one.help.clone().unwrap_or_default()))
                .collect::<String>(),
            other => other.to_string(),
        };
        assert!(parts.iter().all(|part| told.contains(part)), "{from} -> {to}: {told}");
    }
}

#[test]
fn a_state_parameter_counts_from_the_critical_state() {
    let with = |line: &str| {
        FILE.replace("test = \"relative_density\"", "test = \"state_parameter\"")
            .replace("[[calibration.quantity]]", line)
    };
    let quantity = "[[calibration.quantity]]";
    let refused = |text: &str| parsed(text, CASE).unwrap_err().to_string();
    let told = refused(&with(quantity));
    assert!(told.contains("state parameter counts from the critical state"), "{told}");
    let told = refused(&with(&format!("[calibration.critical_state]\nslope = 0.02\n{quantity}")));
    assert!(told.contains("critical_state needs void_ratio"), "{told}");
    let line = "[calibration.critical_state]\nvoid_ratio = 1.0\nslope = 0.02\n";
    let file = parsed(&with(&format!("{line}{quantity}")), CASE).unwrap();
    let line = file.calibration.critical_state.unwrap();
    assert!((line.at(101_325.0) - 0.98).abs() < 1e-12 && line.exponent == 0.7);
    let test = granum_io::LaboratoryTest {
        name: "A".into(),
        axial_strain: vec![0.0, 0.2],
        deviator_stress: vec![0.0, 1e5],
        mean_stress: vec![101_325.0, 1.3e5],
        void_ratio: vec![0.9, 0.95],
        ..granum_io::LaboratoryTest::default()
    };
    let other = granum_io::LaboratoryTest { name: "B".into(), ..test.clone() };
    let targets = crate::simulations::target::targets(&file, &[test, other]).unwrap();
    // Denser than the critical state by 0.08.
    assert!((targets[0].conditions[1] + 0.08).abs() < 1e-12, "{:?}", targets[0].conditions);
}

#[test]
fn pore_pressure_is_what_the_lateral_stress_has_lost() {
    let test = granum_io::LaboratoryTest {
        axial_strain: vec![0.0, 0.1],
        deviator_stress: vec![0.0, 6e4],
        mean_stress: vec![1e5, 7e4],
        ..granum_io::LaboratoryTest::default()
    };
    // The lateral stress falls from 100 to 50 kPa.
    assert_eq!(*Quantity::PORE_PRESSURE.readings(&test), [0.0, 5e4]);
}

/// Cases count cycles: a value between two numbers of cycles would be refused.
#[test]
fn a_free_variable_that_counts_gives_cases_whole_numbers() {
    let cycles = "\n[[variable]]\nname = \"cycles\"\nkey = \"preparation.cycles\"\nprior = \"uniform\"\nfrom = 0\nto = 6\n";
    let counted = file(&format!("{STRESS_AND_FRICTION}{cycles}"));
    assert_eq!((counted.free[0].step, counted.free[1].step), (None, Some(1.0)));
    let points = crate::simulations::simulation::design(&counted, 1);
    assert!(
        points.iter().all(|point| point.values[1].fract() == 0.0 && (0.0..=6.0).contains(&point.values[1]))
    );
    let different: std::collections::BTreeSet<u64> =
        points.iter().map(|point| point.values[1] as u64).collect();
    assert_eq!(different.len(), 7, "{different:?}");
    assert_eq!(crate::simulations::simulation::of_test(&counted, 1, &[0.4, 3.4], 0), [0.4, 3.0]);
    let in_steps = file(&format!("{STRESS_AND_FRICTION}step = 0.25\n"));
    let friction = |value: f64| in_steps.free[0].in_case(value);
    // From 0.2 to 0.8 in steps of 0.25 there are 0.25, 0.5 and 0.75.
    assert_eq!([0.2, 0.3, 0.6, 0.8].map(friction), [0.25, 0.25, 0.5, 0.75]);
    let narrow = format!("{STRESS_AND_FRICTION}{}", cycles.replace("from = 0", "from = 5.5"));
    let refused = parsed(&narrow, PLAIN_CASE).unwrap_err().to_string();
    assert!(
        refused.contains("only one multiple of the step 1, 6, lies in the range from 5.5 to 6"),
        "{refused}"
    );
}
