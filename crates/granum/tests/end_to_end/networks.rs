//! Training, prediction and evaluation with small and fast simulations, which are too coarse for physical conclusions but
//! exercise the whole program.

use std::path::Path;

use serde_json::Value;

use crate::{SMALL, done, done_json, refused};

/// Runs a test over the whole range of strain, with enough states for every sub-model.
pub fn make_run(here: &Path, seed: u64) {
    make_run_of(here, &format!("run-{seed}"), |case| {
        case.replace("[preparation]", &format!("[preparation]\nseed = {seed}"))
    });
}

/// Such a test with a modified case.
pub fn make_run_of(here: &Path, name: &str, change: impl FnOnce(&str) -> String) {
    let case = SMALL
        .replace("deviator_strain = 0.02", "deviator_strain = 0.3")
        .replace("inertial_number = 3e-3", "inertial_number = 1e-2")
        .replace("states = 8", "states = 40");
    std::fs::write(here.join("case.toml"), change(&case)).unwrap();
    done(here, &["shear", "case.toml", "--out", name]);
}

fn close(a: &Value, b: &Value) -> bool {
    (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-12
}

#[test]
fn a_study_is_trained_judged_and_asked() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    for seed in 1..=2 {
        make_run(here, seed);
    }
    let quick = ["--trainer", "traingdx", "--epoch-factor", "2e-4", "--seed", "7"];
    let mut train = vec!["train", "run-1", "--unseen", "run-2", "--out", "study"];
    train.extend(quick);
    let trained = done_json(here, &train);
    let message = refused(here, 1, &train);
    assert!(message.contains("study already contains a finished training"), "{message}");

    // The scores from the saved files are those at the end of training, and they are reproducible.
    let judged = done_json(here, &["evaluate", "study", "run-2"]);
    let mappings = judged["runs"][0]["mappings"].as_array().unwrap();
    assert_eq!(mappings.len(), 6);
    for scored in mappings {
        let before = &trained["mappings"][scored["mapping"].as_str().unwrap()];
        assert!(close(&scored["network"]["relative_rmse"], &before["relative_rmse"]["unseen"]), "{scored}");
        assert!(close(&scored["network"]["r2"], &before["r2"]["unseen"]), "{scored}");
        assert!(close(&scored["strain_only"]["r2"], &before["r2"]["strain_only"]), "{scored}");
        // The baselines are stored with the study.
        for name in ["ridge", "ridge_strain_only", "mean_curve"] {
            assert!(close(&scored[name]["relative_rmse"], &before[name]), "{name}: {scored}");
        }
        assert_eq!(before["verdict"], "cannot be told from so few runs");
        assert!(before["with_other_sensors"].is_null() && before["use"].is_null(), "{before}");
        assert!(
            before["with_permuted_sensors"].is_number() && before["help"]["mean"].is_number(),
            "{before}"
        );
        assert!(before["sub_models"][0]["constant"].is_boolean(), "{before}");
    }
    let on_training = done_json(here, &["evaluate", "study", "run-1"]);
    assert!(
        on_training["warnings"][0].as_str().unwrap().contains("the networks were trained on every second")
    );
    let text = done(here, &["evaluate", "study", "run-1", "run-2"]);
    assert!(text.contains("run-2 (seed 2)") && text.contains("relative RMSE"), "{text}");
    assert!(text.contains("ridge, strain only") && text.contains("mean curve"), "{text}");
    // A training run does not count as a further unseen run.
    assert!(
        text.contains("over 1 unseen run,") && text.contains("cannot be told from so few runs"),
        "{text}"
    );
    make_run(here, 3);
    let judged = done_json(here, &["evaluate", "study", "run-2", "run-3"]);
    let sensors = judged["sensors"].as_array().unwrap();
    assert_eq!(sensors.len(), 6);
    for used in sensors {
        assert!(used["with_other_sensors"]["relative_rmse"].is_number(), "{used}");
        assert_eq!((&used["use"]["runs"], &used["use"]["above_zero"]), (&2.into(), &Value::Null), "{used}");
    }

    // A training that was interrupted before its last file is resumed and gives the same networks.
    std::fs::remove_file(here.join("study/study.json")).unwrap();
    std::fs::remove_file(here.join("study/F3-antony2006.json")).unwrap();
    let again = done_json(here, &train);
    assert_eq!(again["mappings"]["F3"]["relative_rmse"], trained["mappings"]["F3"]["relative_rmse"]);

    // The default trainer estimates its uncertainty; with a single training run it states that the scatter between samples
    // is unknown.
    done(here, &["train", "run-1", "--form", "histogram", "--out", "sure"]);
    let ask =
        ["predict", "sure", "-m", "F4", "-s", "deviator_strain=0.1", "-s", "deviator_fabric=0.12", "-s"];
    let ask = [&ask[..], &["force=1.125"]].concat();
    let predicted = done_json(here, &ask);
    let number = |key: &str| predicted[key].as_f64().unwrap();
    // With 20 states of a single run, the standard deviation can only be required to be positive.
    assert!(number("standard_deviation") > 0.0, "{predicted}");
    assert!(number("lower") < number("value") && number("value") < number("upper"), "{predicted}");
    assert!(predicted["runs_of_interval"].is_null() && predicted["constant"] == false, "{predicted}");
    let text = done(here, &ask);
    assert!(text.contains("90 % interval") && text.contains("does not include the scatter"), "{text}");
    done(here, &["train", "run-1", "run-2", "--out", "two"]);
    let ask = [&["predict", "two"], &ask[2..]].concat();
    let predicted = done_json(here, &ask);
    assert!(predicted["standard_deviation"].as_f64().unwrap() < 0.5, "{predicted}");
    let text = done(here, &ask);
    assert!(text.contains("the scatter between samples, estimated from 2 training runs"), "{text}");

    one_row(here);
    many_rows(here);
}

/// Centres of the learned bins of f.
fn bins() -> impl Iterator<Item = f64> {
    (0..14).map(|bin| 0.125 + 0.25 * bin as f64)
}

/// A state for F1 as arguments of `--set`; the networks of `study` have point form.
fn state(strain: &str) -> Vec<String> {
    let density = |f: f64| format!("probability_density_{f}={}", 0.05 + 0.4 * (-f).exp());
    let values = std::iter::once(format!("deviator_strain={strain}")).chain(bins().map(density));
    values.flat_map(|value| ["--set".to_string(), value]).collect()
}

fn one_row(here: &Path) {
    let ask = |strain: &str| -> Vec<String> {
        let head = ["predict", "study", "--mapping", "F1"].map(str::to_string);
        head.into_iter().chain(state(strain)).collect()
    };
    let words = |all: &[String]| -> Vec<String> { all.to_vec() };
    let inside = words(&ask("0.12"));
    let predicted = done_json(here, &inside.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!((&predicted["sub_model"], &predicted["output"]), (&2.into(), &"stress_ratio".into()));
    assert!(predicted["standard_deviation"].is_null() && predicted["lower"].is_null(), "{predicted}");
    let ratio = predicted["value"].as_f64().unwrap();
    assert!((0.2..1.2).contains(&ratio), "{ratio}");

    let far = ask("0.4");
    let text = done(here, &far.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(text.contains("OUTSIDE the trained range: deviator_strain = 0.4 (trained from"), "{text}");
    assert!(text.contains("networks trained by traingdx do not estimate their uncertainty"), "{text}");
    let message =
        refused(here, 1, &inside[..inside.len() - 2].iter().map(String::as_str).collect::<Vec<_>>());
    assert!(message.contains("missing: probability_density_3.375"), "{message}");
    assert!(
        message.contains("probability_density_0.125 to probability_density_3.375 (14 bins):"),
        "{message}"
    );

    let ask = |values: &[&str]| {
        let mut all = vec!["predict", "study", "--mapping", "F2"];
        values.iter().for_each(|value| all.extend(["--set", value]));
        refused(here, 1, &all)
    };
    let message = ask(&["deviator_strain=0.1"]);
    assert!(message.contains("missing: stress_ratio, force") && message.contains("force: 0.125 to 3.375"));
    let message = ask(&["deviator_strian=0.1"]);
    assert!(message.contains("did you mean deviator_strain?"), "{message}");
    let message = ask(&["force=much"]);
    assert!(message.contains("\"much\" does not start with a number"), "{message}");
    let message = ask(&["force=100 kPa"]);
    assert!(message.contains("\"100 kPa\" is a stress; it must be a pure number"), "{message}");
    let message = refused(here, 1, &["predict", "study", "--mapping", "F9"]);
    assert!(message.contains("no mapping `F9`; there are: F1, F2"), "{message}");
}

fn many_rows(here: &Path) {
    let names: Vec<String> = bins().map(|f| format!("probability_density_{f}")).collect();
    let densities: Vec<String> = bins().map(|f| (0.05 + 0.4 * (-f).exp()).to_string()).collect();
    let densities = densities.join(",");
    let rows = format!(
        "id,deviator_strain,{}\n1,0.12,{densities}\n2,0.05,{densities}\n3,0.5,{densities}\n",
        names.join(",")
    );
    std::fs::write(here.join("rows.csv"), &rows).unwrap();
    let ask = ["predict", "study", "--mapping", "F1", "--input", "rows.csv", "-o", "predictions.csv"];
    let told = done_json(here, &ask);
    assert_eq!((&told["rows"], &told["rows_outside"]), (&3.into(), &1.into()));
    assert!(told["warnings"][0].as_str().unwrap().contains("1 of 3 rows lie outside"), "{told}");
    let table = granum_io::read_table(here.join("predictions.csv")).unwrap();
    assert_eq!(table.column("outside").unwrap(), [0.0, 0.0, 1.0]);
    assert_eq!(table.column("sub_model").unwrap(), [2.0, 1.0, 3.0]);
    let ask_one: Vec<String> = state("0.05");
    let mut one = vec!["predict", "study", "-m", "F1"];
    one.extend(ask_one.iter().map(String::as_str));
    let one = done_json(here, &one);
    let same = table.column("predicted_stress_ratio").unwrap()[1];
    assert!((one["value"].as_f64().unwrap() - same).abs() < 1e-12);
    let two = done_json(here, &["predict", "two", "-m", "F1", "--input", "rows.csv"]);
    assert!(two["lower"][0].as_f64().unwrap() < two["upper"][0].as_f64().unwrap(), "{two}");

    assert!(refused(here, 1, &ask).contains("predictions.csv exists already"));
    std::fs::write(here.join("rows.csv"), rows.replacen("2,0.05", "2,many", 1)).unwrap();
    let message = refused(here, 1, &ask[..6]);
    assert!(message.contains("rows.csv:3:"), "{message}");
    std::fs::write(
        here.join("rows.csv"),
        rows.replacen("2,0.05,", "2,0.05,,", 1).replacen(
            &format!("{}\n3,", &densities[densities.rfind(',').unwrap()..]),
            "\n3,",
            1,
        ),
    )
    .unwrap();
    let message = refused(here, 1, &ask[..6]);
    assert!(message.contains("probability_density_0.125") && message.contains("empty"), "{message}");
    std::fs::write(here.join("rows.csv"), rows.replace("density_1.375", "density_1.3")).unwrap();
    let message = refused(here, 1, &ask[..6]);
    assert!(message.contains("probability_density_1.375") && message.contains("rows.csv"), "{message}");
}

#[test]
fn what_cannot_be_trained_is_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    make_run(here, 1);
    let message = refused(here, 1, &["train", "run-1", "--unseen", "./run-1"]);
    assert!(message.contains("run-1 and ./run-1 are the same run"), "{message}");
    let message = refused(here, 1, &["train", "run-1", "--trainer", "adem"]);
    assert!(
        message.contains("adem") && message.contains("adam") && message.contains("traingdx"),
        "{message}"
    );
    let message = refused(here, 1, &["train", "run-1", "--epoch-factor", "0.1"]);
    assert!(message.contains("only traingdx trains for the epochs"), "{message}");
    let message = refused(here, 1, &["train", "run-1", "--trainer", "traingdx", "--epoch-factor", "-1"]);
    assert!(message.contains("more than 0"), "{message}");
    let message = refused(here, 1, &["evaluate", "run-1", "run-1"]);
    assert!(message.contains("a study is needed here"), "{message}");
    std::fs::write(here.join("run-1/series.parquet"), "PAR1").unwrap();
    let message = refused(here, 1, &["train", "run-1"]);
    assert!(message.contains("series.parquet"), "{message}");
    assert!(!here.join("study").exists());
}

/// A surrogate that a program saved is asked by the command line, by its own columns.
#[test]
fn a_saved_surrogate_is_asked() {
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};
    use granum_learn::{Dataset, FitSpec, RunStates, SurrogateMethods, surrogate};

    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let run = |k: u32| {
        let x: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
        let y = x.iter().map(|x| 2.0 * x + 0.1 * f64::from(k) + 0.01 * (90.0 * x).sin()).collect();
        let table = Table::new(vec![Column::new("x", "m", x), Column::new("y", "Pa", y)]).unwrap();
        RunStates::new(&format!("run-{k}"), table).unwrap()
    };
    let dataset = Dataset::new((1..=3).map(run).collect()).unwrap();
    let methods = SurrogateMethods::standard();
    let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
    let fitted = methods.by_name("ridge").unwrap().fit(&dataset, &spec, &mut NoObserver).unwrap();
    surrogate::save(&here.join("s.json"), fitted.as_ref()).unwrap();

    let asked = done_json(here, &["predict", "s.json", "--set", "x=1.5"]);
    assert!(asked["warnings"][0].as_str().unwrap().contains("OUTSIDE the trained range"), "{asked}");
    let asked = done_json(here, &["predict", "s.json", "--set", "x=0.5"]);
    let known = &fitted.predict_rows(&[0.5], 0.9).unwrap()[0].values[0];
    assert_eq!(asked["outputs"][0]["mean"], known.mean);
    assert_eq!(asked["outputs"][0]["upper"], known.interval.as_ref().unwrap().upper);
    assert!(asked["outputs"][0]["standard_deviations"]["runs"].as_f64().unwrap() > 0.05, "{asked}");
    let text = done(here, &["predict", "s.json", "--set", "x=1.5"]);
    assert!(text.contains("y = ") && text.contains("90 % interval") && text.contains("runs"), "{text}");
    assert!(text.contains("OUTSIDE the trained range: x = 1.5 (trained from 0 to 1)"), "{text}");

    std::fs::write(here.join("rows.csv"), "x,other\n0.5,1\n2.5,1\n").unwrap();
    done(here, &["predict", "s.json", "--input", "rows.csv", "--output", "predictions.csv"]);
    let predictions = granum_io::read_table(here.join("predictions.csv")).unwrap();
    assert_eq!(predictions.column("predicted_y").unwrap()[0], known.mean);
    assert_eq!(predictions.column("outside").unwrap(), [0.0, 1.0]);

    let message = refused(here, 1, &["predict", "s.json", "--mapping", "F1", "--set", "x=1"]);
    assert!(message.contains("is the file of one surrogate"), "{message}");
    let message = refused(here, 1, &["predict", "s.json"]);
    assert!(
        message.contains("missing: x") && message.contains("the surrogate (ridge) needs: x"),
        "{message}"
    );
    let text = std::fs::read_to_string(here.join("s.json")).unwrap();
    std::fs::write(here.join("s.json"), text.replace("\"x\"", "\"z\"")).unwrap();
    let message = refused(here, 1, &["predict", "s.json", "--set", "x=1"]);
    assert!(message.contains("s.json: the SHA-256 does not match the content"), "{message}");
}
