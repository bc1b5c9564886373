//! What families are asked: several tests at once, properties that are not known, the ends of their ranges, and what is no question.

use std::path::Path;

use serde_json::Value;

use crate::example_grains::{POWDER, SAND};
use crate::{done, done_json, refused};

/// A question about the sand, with further flags.
fn sand<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["predict", "--family", "sand"], &SAND[..], more].concat()
}

/// The same with other values of flags.
fn other_sand<'a>(others: &[(&str, &'a str)], more: &[&'a str]) -> Vec<&'a str> {
    let mut words = sand(more);
    for (flag, value) in others {
        let place = words.iter().position(|word| word == flag).unwrap();
        words[place + 1] = value;
    }
    words
}

fn input<'a>(answer: &'a Value, name: &str) -> &'a Value {
    answer["inputs"].as_array().unwrap().iter().find(|input| input["input"] == name).unwrap()
}

fn curve(answer: &Value, column: &str, part: &str) -> Vec<f64> {
    let values = answer["curves"][column][part].as_array().unwrap();
    values.iter().map(|value| value.as_f64().unwrap()).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The ends of the documented ranges are within them, and what is typical there is what occurs.
#[test]
fn the_ends_of_the_ranges_are_within_them() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let end = [
        ("--friction", "0.8"),
        ("--rolling-friction", "0.5"),
        ("--pressure", "50 kPa"),
        ("--youngs-modulus", "5 GPa"),
    ];
    let answer = done_json(here, &other_sand(&end, &["--spread", "0"]));
    assert_eq!(answer["outside"].as_array().map(Vec::len), Some(0), "{:#}", answer["outside"]);
    // Grains of one size, as others hardly differ.
    let typical = |answer: &Value, name: &str| input(answer, name)["value"].as_f64().unwrap();
    let [one, many] =
        [sand(&["--spread", "0"]), sand(&["--spread", "0.05"])].map(|asked| done_json(here, &asked));
    for name in ["sample.void_ratio", "preparation_ratio", "sample.mechanical_coordination_number"] {
        let [one, many] = [typical(&one, name), typical(&many, name)];
        assert!((one - many).abs() < 0.1 * many.abs(), "{name}: {one} {many}");
    }
    let strength = |answer: &Value| largest(&curve(answer, "stress_ratio", "mean"));
    let [one, many] = [strength(&one), strength(&many)];
    assert!((one - many).abs() < 0.1 * many, "{one} {many}");
    let beyond = done_json(here, &other_sand(&[("--friction", "0.81")], &[]));
    assert_eq!(beyond["outside"][0]["input"], "friction", "{:#}", beyond["outside"]);
    assert_eq!(beyond["outside"][0]["range"], serde_json::json!([0.1, 0.8]));
}

#[test]
fn what_is_no_question_is_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let told = |arguments: &[&str]| refused(here, 1, arguments);
    // Options that are without effect.
    let message = told(&sand(&["--interface-energy", "5 mJ/m2"]));
    assert!(message.contains("--interface-energy") && message.contains("do not depend on it"), "{message}");
    assert!(message.contains("--rolling-friction, --pressure"), "{message}");
    let powder = |modulus: &'static str, more: &[&'static str]| {
        let (last, others) = POWDER.split_last().unwrap();
        assert_eq!(*last, "200 MPa");
        [&["predict", "--family", "powder"], others, &[modulus], more].concat()
    };
    assert!(
        told(&powder("200 MPa", &["--spread", "0.1"])).contains("--spread: the tests of the family powder")
    );
    assert!(told(&sand(&["--card"])).contains("--friction: a card does not depend on it"));
    assert!(told(&["predict", "--family", "sand", "--card", "-o", "card.csv"]).contains("--output card.csv"));
    assert!(told(&["predict", "--friction", "0.4", "--family"]).contains("the list of the families"));
    // Numbers whose unit was forgotten.
    let message = told(&other_sand(&[("--youngs-modulus", "70")], &[]));
    assert!(message.contains("--youngs-modulus \"70\" is out of bounds"), "{message}");
    assert!(message.contains("70 GPa"), "{message}");
    assert!(told(&other_sand(&[("--pressure", "100")], &[])).contains("probably 100 kPa was meant"));
    assert!(told(&other_sand(&[("--friction", "0,4")], &[])).contains("decimal comma"));
    // Numbers beyond all grains have no answer.
    for modulus in ["1e-300", "1e-300 Pa", "1e-310 Pa", "0 Pa"] {
        let message = told(&powder(modulus, &[]));
        assert!(
            message.contains("youngs-modulus") || message.contains("stress_over_modulus"),
            "{modulus}: {message}"
        );
        assert!(!message.contains("NaN"), "{message}");
    }
    // A check is of one sample.
    assert!(told(&other_sand(&[("--friction", "0.3,0.4")], &["--check"])).contains("one sample"));
    assert!(
        told(&["predict", "--family", "sand", "--friction", "0.4", "--check"]).contains("rolling_friction")
    );
}

#[test]
fn a_property_that_is_not_known_is_integrated_over() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let open: Vec<&str> = [&["predict", "--family", "sand"], &SAND[2..]].concat();
    let answer = done_json(here, &open);
    assert_eq!(input(&answer, "friction")["integrated_over"], serde_json::json!([0.1, 0.8]), "{answer:#}");
    assert_eq!(input(&answer, "rolling_friction")["integrated_over"], Value::Null);
    let text = done(here, &open);
    assert!(
        text.contains("friction = 0.1 to 0.8 (not given: integrated over the range of the runs)"),
        "{text}"
    );
    let end = |answer: &Value, part: &str| *curve(answer, "stress_ratio", part).last().unwrap();
    let [weak, strong] =
        ["0.1", "0.8"].map(|friction| done_json(here, &other_sand(&[("--friction", friction)], &[])));
    let mean = end(&answer, "mean");
    assert!(end(&weak, "mean") < mean && mean < end(&strong, "mean"), "{mean}");
    let [lower, upper] = ["lower", "upper"].map(|part| end(&answer, part));
    assert!(end(&weak, "lower") < lower && upper < end(&strong, "upper"), "{lower} {upper}");
    let known = done_json(here, &sand(&[]));
    assert!(upper - lower > 1.5 * (end(&known, "upper") - end(&known, "lower")), "{lower} {upper}");
    // Without the modulus the pressure says nothing.
    let stress = done_json(here, &[&["predict", "--family", "sand"], &SAND[..6]].concat());
    assert_eq!(input(&stress, "stress_over_modulus")["integrated_over"], serde_json::json!([1e-5, 4e-4]));
}

#[test]
fn several_tests_are_asked_at_once() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let several = other_sand(&[("--friction", "0.3, 0.6")], &["--void-ratio", "0.65,0.75"]);
    let answer = done_json(here, &[&several[..], &["-o", "curves.csv"]].concat());
    let tests = answer["tests"].as_array().unwrap();
    assert_eq!(tests.len(), 4, "{answer:#}");
    assert_eq!(tests[2]["asked"], serde_json::json!({ "friction": 0.6, "void_ratio": 0.65 }));
    // Each is what it is alone.
    let alone = done_json(here, &other_sand(&[("--friction", "0.6")], &["--void-ratio", "0.65"]));
    assert_eq!(tests[2]["curves"], alone["curves"]);
    let table = std::fs::read_to_string(here.join("curves.csv")).unwrap();
    assert!(table.starts_with("test,asked_friction,asked_void_ratio,friction,"), "{table}");
    assert_eq!(table.lines().count(), 1 + 4 * alone["axial_strain"].as_array().unwrap().len());
    let text = done(here, &[&several[..], &["-o", "curves.svg"]].concat());
    assert!(text.contains("rolling friction = 0.1 (given)") && text.contains("stress_ratio"), "{text}");
    let figure = std::fs::read_to_string(here.join("curves.svg")).unwrap();
    for part in
        ["friction 0.3, void ratio 0.65", "90 % of the states of new samples", "rolling friction = 0.1"]
    {
        assert!(figure.contains(part), "{part}");
    }
    let many = other_sand(&[("--friction", "0.1,0.2,0.3,0.4,0.5,0.6,0.7,0.8,0.45")], &["-o", "many.svg"]);
    assert!(refused(here, 1, &many).contains("8 tests at most"));
    rows_of_a_table(here);
}

/// The rows of a table, in which a cell that is empty is not known.
fn rows_of_a_table(here: &Path) {
    let write = |text: &str| std::fs::write(here.join("sands.csv"), text).unwrap();
    let asked = ["predict", "--family", "sand", "--youngs-modulus", "2 GPa", "--input", "sands.csv"];
    write("friction,rolling_friction,pressure (kPa)\n0.5,0.1,100\n0.3,0.2,200\n");
    let answer = done_json(here, &asked);
    let tests = answer["tests"].as_array().unwrap();
    assert_eq!((tests.len(), &tests[0]["curves"]), (2, &done_json(here, &sand(&[]))["curves"]));
    assert!((tests[1]["asked"]["pressure"].as_f64().unwrap() - 2e5).abs() < 1e-6, "{:#}", tests[1]["asked"]);
    for (text, parts) in [
        ("frction\n0.5\n", ["sands.csv", "did you mean friction?"]),
        ("friction,interface_energy\n0.5,0.01\n", ["column interface_energy", "do not depend on it"]),
        ("friction,pressure\n0.5,1e5\n0.5,100\n", ["row 2: pressure", "probably 100 kPa was meant"]),
        ("depth\n3\n", ["sands.csv", "no column of a property"]),
        ("friction\n-1\n", ["row 1: friction", "cannot be negative"]),
    ] {
        write(text);
        let message = refused(here, 1, &asked);
        assert!(parts.iter().all(|part| message.contains(part)), "{text}: {message}");
    }
}

/// The figure of a check has the test over the prediction for the sample that was made, and says what it shows.
#[test]
fn a_check_is_drawn_over_the_prediction_for_its_sample() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let check = [
        "--path",
        "undrained-triaxial",
        "--void-ratio",
        "0.72",
        "--check",
        "--grains",
        "200",
        "--force",
        "-o",
    ];
    let text = done(here, &[&sand(&check)[..], &["checked.svg"]].concat());
    assert!(text.contains("curves for the sample that was made (●), and its test (×)"), "{text}");
    assert!(text.contains('×'), "{text}");
    let figure = std::fs::read_to_string(here.join("checked.svg")).unwrap();
    for part in ["a simulation of 200 grains", "friction = 0.5", "bands: 90 %"] {
        assert!(figure.contains(part), "{part}");
    }
    let answer = done_json(here, &[&sand(&check)[..], &["checked.json"]].concat());
    let drawn = &answer["check"]["curves"]["stress_ratio"];
    let points = answer["axial_strain"].as_array().unwrap().len();
    for part in ["measured", "mean", "lower", "upper"] {
        assert_eq!(drawn[part].as_array().map(Vec::len), Some(points), "{part}");
    }
    // The sample that was made is not the one that is typical.
    assert_ne!(drawn["mean"], answer["curves"]["stress_ratio"]["mean"]);
    let written: Value =
        serde_json::from_str(&std::fs::read_to_string(here.join("checked.json")).unwrap()).unwrap();
    assert_eq!(written["check"], answer["check"]);
}
