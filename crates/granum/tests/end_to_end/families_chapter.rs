//! The commands of the chapter of families work exactly as they are printed, with smaller samples and fewer points; and what families answer
//! and refuse.

use std::path::Path;

use crate::chapter::{change, words};
use crate::common::{run, stderr};
use crate::example_grains::{LONG_GRAINS, POWDER, SAND};
use crate::{done, done_json, refused};

const CHAPTER: &str = include_str!("../../../../docs/src/families.md");

/// The commands of a section of the chapter, in order; a line that ends with a backslash goes on.
fn commands(section: &str) -> Vec<Vec<String>> {
    let text = CHAPTER.split(section).nth(1).unwrap_or_default();
    let text = text.split("\n##").next().unwrap_or_default();
    let blocks = text.split("```sh\n").skip(1).map(|text| text.split("```").next().unwrap_or_default());
    let lines: Vec<String> = blocks
        .flat_map(|block| block.replace("\\\n", " ").lines().map(String::from).collect::<Vec<_>>())
        .collect();
    lines
        .iter()
        .map(|line| words(line))
        .filter(|words| words.first().is_some_and(|word| word == "granum"))
        .collect()
}

/// Fewer and smaller samples, and a short test.
fn smaller(here: &Path, plan: &str, points: &str, wanted: &str) {
    let changes = [
        ("grains.count = 1000", "grains.count = 60"),
        ("stage.1.axial_strain = 0.25", "stage.1.axial_strain = 0.02"),
        ("stage.1.states = 250", "stage.1.states = 10"),
        (points, wanted),
        ("largest_overlap < 0.1\"", "largest_overlap < 1\""),
        (
            "largest_overlap < 0.06\"",
            "largest_overlap < 1\", \"inertial_number < 1\", \"sample_unbalanced_force < 1\", \"unbalanced_force < 1\", \"servo_error_rms < 1\", \"servo_error_largest < 9\", \"sample_mean_stress_missed_by < 1\", \"energy_gap < 1\", \"mean_stress_lost < 1\"",
        ),
    ];
    change(&here.join(plan), &changes);
    let faster = [
        ("inertial_number = 1e-3", "inertial_number = 1e-2"),
        ("inertial_number = 2e-3", "inertial_number = 1e-2"),
        ("unbalanced_force = 2e-3", "unbalanced_force = 5e-2"),
    ];
    let case = std::fs::read_to_string(here.join("drained-dense.toml")).unwrap();
    if case.contains("unbalanced_force = 2e-3") {
        change(&here.join("drained-dense.toml"), &faster);
    }
}

/// The family that comes with the program.
#[test]
fn the_family_of_the_program_answers_as_in_the_chapter() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let commands = commands("## What is asked and answered");
    assert_eq!(commands.len(), 7, "{commands:?}");
    let readme = include_str!("../../../../README.md").replace("\\\n", " ");
    assert!(readme.lines().any(|line| words(line) == commands[0]), "README has another command");
    let said = |words: &[String]| done(here, &words[1..].iter().map(String::as_str).collect::<Vec<_>>());
    let said: Vec<String> = commands.iter().map(|words| said(words)).collect();
    assert!(said[0].contains("void ratio = 0.7 (given)") && said[0].contains("q/p = "), "{}", said[0]);
    assert!(!said[0].contains("OUTSIDE"), "{}", said[0]);
    assert!(
        said[1].starts_with("sand --path drained-triaxial: sands in drained triaxial compression\n"),
        "{}",
        said[1]
    );
    assert!(said[2].contains("## Where not to use it"), "{}", said[2]);
    assert!(said[4].contains("friction = 0.5 (given)"), "{}", said[4]);
    assert!(said[5].contains("interface energy over") || said[5].contains("adhesion number"), "{}", said[5]);
    assert!(
        said[6].contains("0.3") && said[6].contains("0.7") && said[6].contains("integrated over"),
        "{}",
        said[6]
    );
    let figures = ["curves.svg", "oedometer.svg", "frictions.svg"];
    assert!(figures.iter().all(|name| here.join(name).is_file()));
}

/// The family of the program on further sands, of which there are two here, and whose tests go as far as those of the family.
#[test]
fn quarters_of_the_inputs_are_judged_as_in_the_chapter() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let commands = commands("### In each quarter of each input");
    assert_eq!(commands.len(), 3, "{commands:?}");
    let mut said = String::new();
    for words in &commands {
        let words: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        said = done(here, &words);
        if words.starts_with(&["init"]) {
            smaller(here, "sand-drained-quarters.toml", "points = 256", "points = 2");
            let as_far = [
                ("stage.1.axial_strain = 0.02", "stage.1.axial_strain = 0.25"),
                ("stage.1.states = 10", "stage.1.states = 250"),
            ];
            change(&here.join("sand-drained-quarters.toml"), &as_far);
        }
    }
    assert!(
        said.contains("quarters (2 runs, each of a material of its own)") && said.contains("| stress_ratio "),
        "{said}"
    );
}

#[test]
fn a_family_is_made_judged_and_asked_as_in_the_chapter() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let commands = commands("## A family made again");
    assert!(commands.len() >= 7, "{commands:?}");
    for words in &commands {
        let mut words: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        if words.contains(&"--check") {
            words.extend(["--grains", "60"]);
        }
        if words.starts_with(&["init"]) && here.join("drained-dense.toml").is_file() {
            // The second plan has the case of the first one.
            words.push("--force");
        }
        let said = done(here, &words);
        match words[..] {
            ["init", "--plan", "sand-drained", ..] => {
                smaller(here, "sand-drained.toml", "points = 500", "points = 10")
            }
            ["init", "--plan", "sand-drained-unseen", ..] => {
                smaller(
                    here,
                    "sand-drained-unseen.toml",
                    "points = 16\nreplicates = 8",
                    "points = 2\nreplicates = 2",
                );
            }
            ["evaluate", ..] => {
                assert!(said.contains("| stress_ratio ") && said.contains("2 materials"), "{said}")
            }
            _ => {}
        }
    }
    let figure = std::fs::read_to_string(here.join("curves.svg")).unwrap();
    assert!(figure.contains("<svg") && figure.contains("Mechanical coordination number"), "{figure}");
    let table = std::fs::read_to_string(here.join("curves.csv")).unwrap();
    assert!(table.starts_with("axial_strain,stress_ratio,stress_ratio_lower,stress_ratio_upper"), "{table}");
    // The test of the check stands beside the prediction for its sample.
    for column in [",measured_stress_ratio,", ",of_sample_stress_ratio,", ",of_sample_stress_ratio_upper,"] {
        assert!(table.lines().next().unwrap().contains(column), "{column}: {table}");
    }

    // What sensors are worth to the family, along its coordinate and from its inputs.
    let asked = ["worth", "sands", "--family", "sand", "--unseen", "unseen", "--method", "ridge"];
    let worth = done_json(here, &[&asked[..], &["--sensor", "deviator_fabric,sliding_fraction"]].concat());
    let plan = &worth["worth"]["plan"];
    assert_eq!(
        (&plan["coordinate"], &plan["outputs"][1], &plan["properties"][0]),
        (&"axial_strain".into(), &"volumetric_strain".into(), &"friction".into())
    );
    let other = [&asked[..4], &["--path", "constant-p"], &asked[4..]].concat();
    assert!(refused(here, 1, &other).contains("no run of the family sand along the path constant-p"));
    let alone = [&asked[..2], &["--path", "constant-p"], &asked[4..]].concat();
    assert!(refused(here, 2, &alone).contains("--family"));

    // A case gives the inputs, and what it does not give is typical of the runs.
    let given = done(here, &["predict", "--family", "sand.json", "drained-dense.toml"]);
    assert!(given.contains("friction = 0.5 (given)") && given.contains("void ratio = "), "{given}");
    assert!(given.contains("not given: typical"), "{given}");
    // A modulus outside the range is answered and flagged.
    let flags =
        ["--friction", "0.4", "--rolling-friction", "0.2", "--pressure", "100 kPa", "--youngs-modulus"];
    let far = [&["predict", "--family", "sand.json"][..], &flags, &["70 GPa"]].concat();
    assert!(done(here, &far).contains("OUTSIDE the trained range: stress_over_modulus"));
    let json = [&far[..], &["--json"]].concat();
    let answer: serde_json::Value = serde_json::from_str(&done(here, &json)).unwrap();
    assert_eq!(answer["outside"][0]["input"], "stress_over_modulus");
    assert_eq!(answer["curves"]["stress_ratio"]["mean"].as_array().map(Vec::len), Some(65));
    // What lacks, and what is of another kind, is told by its flag.
    let message = refused(here, 1, &["predict", "--family", "sand.json"]);
    assert!(
        message.contains("missing: --friction, --rolling-friction, --pressure, --youngs-modulus"),
        "{message}"
    );
    let path = [&far[..], &["--path", "oedometer"]].concat();
    assert!(refused(here, 1, &path).contains("the tests of sand.json have the path drained-triaxial"));
    let path = ["predict", "--family", "powder", "--path", "oedometer"];
    let message = refused(here, 1, &path);
    assert!(message.contains("missing: --friction, --interface-energy, --pressure, --diameter"), "{message}");
    let message = refused(here, 1, &[&far[..], &["-o", "curves.pdf"]].concat());
    assert!(message.contains("curves.pdf: its name must end in .svg"), "{message}");
    let message = refused(here, 1, &["predict", "--family", "sandy"]);
    assert!(message.contains("there is no family `sandy`; did you mean sand?"), "{message}");
    let message = refused(here, 1, &["train", "sands", "--family", "sand", "-o", "sand.json"]);
    assert!(message.contains("sand.json"), "{message}");
}

/// Every surrogate that comes with the program answers, has been scored on runs that it has not seen, and writes a table over its coordinate.
#[test]
fn every_family_and_path_answers() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let listed = done(here, &["predict", "--family"]);
    let without: Vec<&str> = listed.lines().filter(|line| line.contains("no fitted surrogate")).collect();
    assert!(without.is_empty(), "{listed}");
    for (family, inputs, path, coordinate, last) in [
        ("sand", &SAND[..], "drained-triaxial", "axial_strain", 0.25),
        ("sand", &SAND, "constant-p", "deviator_strain", 0.35),
        ("sand", &SAND, "undrained-triaxial", "axial_strain", 0.08),
        ("sand", &SAND, "unload-reload", "test_progress", 7.0),
        ("powder", &POWDER, "constant-p", "deviator_strain", 0.3),
        ("powder", &POWDER, "oedometer", "test_progress", 1.0),
        ("shaped-sand", &LONG_GRAINS, "drained-triaxial", "axial_strain", 0.25),
    ] {
        let which = ["predict", "--family", family, "--path", path];
        let found = done_json(here, &[&which[..], inputs, &["-o", "curves.csv", "--force"]].concat());
        let points = found[coordinate].as_array().unwrap();
        let end = points.last().unwrap().as_f64().unwrap();
        assert!((end / last - 1.0).abs() < 0.06, "{family} {path}: {end}");
        assert_eq!(found["outside"].as_array().map(Vec::len), Some(0), "{family} {path}: {found}");
        let q = found["curves"]["stress_ratio"]["mean"].as_array().unwrap();
        assert!(q[0].as_f64().unwrap().abs() < 0.05, "{family} {path}: {}", q[0]);
        assert!(q[32].as_f64().unwrap() > 0.2, "{family} {path}: {}", q[32]);
        let table = std::fs::read_to_string(here.join("curves.csv")).unwrap();
        assert!(table.starts_with(&format!("{coordinate},")), "{table}");
        // A small sample of it is made and tested along the same path, whatever comes out.
        let check = ["--check", "--grains", "60", "--force"];
        let checked = run(here, &[&which[..], inputs, &check, &["-o", "checked.csv"]].concat());
        let told = stderr(&checked);
        assert!(checked.status.success() || told.contains("did not pass"), "{family} {path}: {told}");
        let card = done(here, &[&which[..], &["--card"]].concat());
        assert!(card.contains("## On unseen runs: ") && card.contains("| stress_ratio "), "{card}");
    }
}

/// A surrogate of long grains that is fitted to the first of the shipped runs answers, and spheres are not taken for long grains.
#[test]
fn long_grains_are_fitted_and_asked() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/families/shaped-sand");
    let [first, unseen] = ["first", "unseen"].map(|name| data.join(name).display().to_string());
    done(here, &["train", &first, "--family", "shaped-sand", "--unseen", &unseen, "-o", "long.json"]);
    let card = done(here, &["predict", "--family", "long.json", "--card"]);
    assert!(card.contains("48 runs") && card.contains("| stress_ratio "), "{card}");
    let sand = ["--friction", "0.5", "--pressure", "100 kPa", "--youngs-modulus", "2 GPa"];
    let strength = |ratio: &str| {
        let ask = ["predict", "--family", "long.json", "--aspect-ratio", ratio];
        let found = done_json(here, &[&ask[..], &sand[..]].concat());
        let curve = found["curves"]["stress_ratio"]["mean"].as_array().unwrap().clone();
        curve.last().unwrap().as_f64().unwrap()
    };
    let [round, long] = ["1.1", "2"].map(strength);
    assert!(round > 0.6 && long > round + 0.2, "{round}, {long}");
    // Spheres are not of this family, and long grains not of that of spheres.
    std::fs::write(
        here.join("spheres.toml"),
        "[contact]\nnormal = \"hertz\"\ntangential = \"no-slip\"\n[[stage]]\npath = \"drained-triaxial\"\n",
    )
    .unwrap();
    let told = refused(here, 1, &["predict", "--family", "long.json", "spheres.toml"]);
    assert!(told.contains("grains.shape.kind of the case is sphere"), "{told}");
    done(here, &["init", "--case", "long-grains"]);
    let rolling = std::fs::read_to_string(here.join("long-grains.toml"))
        .unwrap()
        .replace("tangential = \"no-slip\"", "tangential = \"no-slip\"\nrolling = \"elastic-plastic\"");
    std::fs::write(here.join("rolling.toml"), rolling).unwrap();
    let told = refused(here, 1, &["predict", "--family", "sand", "rolling.toml"]);
    assert!(told.contains("grains.shape.kind of the case is capsule"), "{told}");
}

/// The sample of a check has the void ratio that was given, or it is said that it could not be reached.
#[test]
fn a_check_is_made_with_the_void_ratio_that_was_given() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let checked = |ratio: &str| {
        let check = ["--path", "undrained-triaxial", "--void-ratio", ratio, "--check", "--grains", "200"];
        let arguments =
            [&["predict", "--family", "sand"], &SAND[..], &check, &["-o", "curves.json", "--force"]].concat();
        let check = done_json(here, &arguments)["check"].clone();
        (check["sample"]["sample.void_ratio"].as_f64().unwrap(), check["void_ratio_missed"].as_f64())
    };
    let (made, missed) = checked("0.72");
    assert!((made - 0.72).abs() < 0.02 && missed.is_none(), "{made} {missed:?}");
    let (made, missed) = checked("0.4");
    assert!(made > 0.5 && missed == Some(0.4), "{made} {missed:?}");
}
