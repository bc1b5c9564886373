//! Calibrations in which nothing fits, a test counts twice, or the simulations never vary what is free: refused, or said before the posterior.

use std::path::Path;

use serde_json::Value;

use crate::calibrations::{MATERIAL, SAND, folder};
use crate::common::{json, run, stderr, stdout};
use crate::{done, refused};

/// Writes the test of the laboratory with its stresses and strains times factors; the mean stress is that of the lateral stress.
fn changed(here: &Path, name: &str, stress: f64, volume: f64) {
    let text = std::fs::read_to_string(here.join("lab.csv")).unwrap();
    let mut lines = text.lines();
    let mut changed = lines.next().unwrap().to_string() + "\n";
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let [e, v, q, p] = [1, 2, 3, 4].map(|k| cells[k].parse::<f64>().unwrap());
        let lateral = p - q / 3.0;
        let (v, q) = (volume * v, stress * q);
        changed += &format!("{},{e},{v},{q},{}\n", cells[0], lateral + q / 3.0);
    }
    std::fs::write(here.join(name), changed).unwrap();
}

/// A calibration on runs that are there, whose confirmation is not simulated.
fn calibrated<'a>(material: &'a str, laboratory: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["calibrate", material, laboratory, "--runs", "out/runs/design"][..], more].concat()
}

#[test]
fn where_nothing_fits_there_is_no_posterior_or_it_is_said_first() {
    let base = folder(true);
    let here = base.path();
    said_first(here);
    let quick = MATERIAL.replace("confirm = 2", "confirm = 0");
    std::fs::write(here.join("quick.toml"), &quick).unwrap();
    let right = quick.replace("confirm = 0", "confirm = 0\ninadequacy = false");
    std::fs::write(here.join("right.toml"), &right).unwrap();

    // Curves far beyond what any simulation reaches, before anything is inferred, with or without an inadequacy.
    changed(here, "fifty.csv", 50.0, 1.0);
    changed(here, "swollen.csv", 1.0, 40.0);
    for (laboratory, part) in
        [("fifty.csv", "deviator stress of T1"), ("swollen.csv", "volumetric strain of T1")]
    {
        for material in ["quick.toml", "right.toml"] {
            let message = refused(here, 1, &calibrated(material, laboratory, &["--out", "no"]));
            for part in [
                "nothing within the priors explains the tests",
                part,
                "everything that the priors reach",
                "units and signs",
                "curves.svg",
            ] {
                assert!(message.contains(part), "{laboratory} {part}: {message}");
            }
        }
    }
    let message = refused(here, 1, &calibrated("quick.toml", "fifty.csv", &["--each-alone", "--out", "no"]));
    assert!(message.contains("nothing within the priors explains the tests"), "{message}");
    assert!(here.join("no/curves.svg").is_file());
    for file in ["posterior.csv", "each-alone.csv", "draws.toml", "calibration.json"] {
        assert!(!here.join("no").join(file).exists(), "{file}");
    }
    results_of_an_earlier_call_are_set_aside(here);
    numbers_beyond_reason(here);
    counted_once(here);
}

/// Where nothing fits, the folder has no result that looks like that of this call; those of an earlier one are kept elsewhere.
fn results_of_an_earlier_call_are_set_aside(here: &Path) {
    let again = |name: &str| here.join("again").join(name);
    let results = ["posterior.csv", "draws.toml", "calibration.json", "report.html", "surrogate.json"];
    done(here, &calibrated("quick.toml", "lab.csv", &["--out", "again"]));
    let posterior = std::fs::read(again("posterior.csv")).unwrap();
    let figure = std::fs::read(again("curves.svg")).unwrap();
    let message = refused(here, 1, &calibrated("quick.toml", "fifty.csv", &["--out", "again"]));
    assert!(
        message.contains("results of an earlier call in again") && message.contains("again/earlier"),
        "{message}"
    );
    for name in results {
        assert!(!again(name).exists() && again("earlier").join(name).is_file(), "{name}");
    }
    assert_eq!(std::fs::read(again("earlier/posterior.csv")).unwrap(), posterior);
    assert_eq!(std::fs::read(again("earlier/curves.svg")).unwrap(), figure);
    assert_ne!(std::fs::read(again("curves.svg")).unwrap(), figure);
    done(here, &calibrated("quick.toml", "lab.csv", &["--out", "again"]));
    assert_eq!(std::fs::read(again("posterior.csv")).unwrap(), posterior);
}

/// What a posterior does not explain stands above its table, in the results and in the report.
fn said_first(here: &Path) {
    changed(here, "three.csv", 3.0, 1.0);
    let output = run(here, &["calibrate", "material.toml", "three.csv", "--out", "out"]);
    let said = stdout(&output);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(said.starts_with("BEFORE THE POSTERIOR IS USED:\n"), "{said}");
    assert!(
        said.contains("does not explain the deviator stress of T1: predictions miss the readings"),
        "{said}"
    );
    let result: Value = json(&std::fs::read_to_string(here.join("out/calibration.json")).unwrap());
    assert_eq!(result["explains_the_tests"], false, "{result:#}");
    let curve = &result["fit"]["curves"][0];
    assert_eq!((&curve["quantity"], &curve["is_explained"]), (&"deviator_stress".into(), &false.into()));
    assert!(curve["misfit"].as_f64().unwrap() > 0.3, "{curve:#}");
    assert!(curve["probability"].as_f64().unwrap() < 1e-6, "{curve:#}");
    assert_eq!(result["against_the_posterior"][0], result["remarks"][0], "{result:#}");
    let report = std::fs::read_to_string(here.join("out/report.html")).unwrap();
    let at = |text: &str| report.find(text).unwrap_or_else(|| panic!("{text}"));
    assert!(at("does not explain the deviator stress of T1") < at("id=\"posterior\""));
}

/// Numbers beyond all reason have no answer, and none that is not a number.
fn numbers_beyond_reason(here: &Path) {
    let columns = "axial_strain,grains.material.friction,grains.material.youngs_modulus";
    std::fs::write(here.join("huge.csv"), format!("{columns}\n0.01,0.3,3e9\n1e308,1e308,1e308\n")).unwrap();
    let answer = |asked: &[&str]| {
        let output = run(here, asked);
        let (said, message) = (stdout(&output).to_lowercase(), stderr(&output));
        match output.status.success() {
            true => assert!(!said.contains("nan") && !said.contains("inf"), "{said}"),
            false => assert!(message.contains("no finite value of"), "{message}"),
        }
    };
    answer(&["predict", "out/surrogate.json", "--input", "huge.csv"]);
    let inputs = columns.split(',').flat_map(|name| ["--set".to_string(), format!("{name}=1e308")]);
    let inputs: Vec<String> = inputs.collect();
    let asked = ["predict", "out/surrogate.json"].into_iter().chain(inputs.iter().map(String::as_str));
    answer(&asked.collect::<Vec<_>>());
}

/// A test counts once, whatever it is named and however often.
fn counted_once(here: &Path) {
    let message = refused(here, 1, &calibrated("quick.toml", "lab.csv", &["--test", "T1", "--test", "T1"]));
    assert!(message.contains("--test T1 is given twice"), "{message}");
    let twice = MATERIAL.replace("runs = 16", "tests = ['T1', 'T1']\nruns = 16");
    std::fs::write(here.join("twice.toml"), twice).unwrap();
    let message = refused(here, 1, &calibrated("twice.toml", "lab.csv", &[]));
    assert!(message.contains("twice.toml:4:") && message.contains("\"T1\" is named twice"), "{message}");
    // The same readings under another name, in other units and with fewer columns.
    let text = std::fs::read_to_string(here.join("lab.csv")).unwrap();
    let mut other = "test,axial_strain (%),deviator_stress (kPa),mean_stress (kPa)\n".to_string();
    for line in text.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        other += &format!("B7,{},{},{}\n", 100.0 * cells[0], cells[2] / 1e3, cells[3] / 1e3);
    }
    std::fs::write(here.join("other.csv"), other).unwrap();
    let both = ["calibrate", "quick.toml", "lab.csv", "other.csv", "--runs", "out/runs/design"];
    let message = refused(here, 1, &both);
    for part in ["\"T1\" and \"B7\"", "the same deviator stress", "count twice"] {
        assert!(message.contains(part), "{message}");
    }
    let blind = [&both[..], &["--test", "T1", "--predict", "B7", "--out", "blind"]].concat();
    let told = stderr(&run(here, &blind));
    assert!(told.contains("\"B7\" has the readings of \"T1\"") && told.contains("not blind"), "{told}");
}

/// Runs that never vary what is free are to blame, and not the tests.
#[test]
fn runs_that_never_vary_what_is_free_are_refused() {
    let base = folder(true);
    let here = base.path();
    let plan = format!(
        "case = 'campaign-sand.toml'\n{}\n[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\n\
         values = [0.15, 0.4, 0.7]\n[[variable]]\nname = 'seed'\nkey = 'preparation.seed'\nvalues = [1, 2, 3]\n",
        MATERIAL.lines().find(|line| line.starts_with("accept")).unwrap()
    );
    std::fs::write(here.join("plan.toml"), plan).unwrap();
    std::fs::write(here.join("campaign-sand.toml"), SAND.replace("3 GPa", "20 GPa")).unwrap();
    done(here, &["campaign", "plan.toml", "--out", "study"]);
    let command = ["calibrate", "material.toml", "lab.csv", "--runs", "study", "--out", "out"];
    let message = refused(here, 1, &command);
    for part in [
        "the runs never vary modulus",
        "grains.material.youngs_modulus is 20 GPa in all 9 of them",
        "1.12 GPa and 8.91 GPa",
        "leave --runs out",
    ] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert!(!message.contains("tell next to nothing"), "{message}");
    assert!(!here.join("out/posterior.csv").exists());
}
