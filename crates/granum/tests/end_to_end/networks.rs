//! Train, predict, evaluate, on small and fast tests of grains: too rough to be cited, right for the machinery.

use std::path::Path;

use serde_json::Value;

use crate::{SMALL, done, done_json, refused};

/// A test over the whole range of strain, with enough states for every sub-model.
pub fn make_run(here: &Path, seed: u64) {
    make_run_of(here, &format!("run-{seed}"), |case| {
        case.replace("[preparation]", &format!("[preparation]\nseed = {seed}"))
    });
}

/// Such a test of a case that was changed.
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
    assert!(message.contains("study already holds a finished training"), "{message}");

    // The same scores from the saved files as at the end of training, and the same ones again.
    let judged = done_json(here, &["evaluate", "study", "run-2"]);
    let mappings = judged["runs"][0]["mappings"].as_array().unwrap();
    assert_eq!(mappings.len(), 6);
    for scored in mappings {
        let before = &trained["mappings"][scored["mapping"].as_str().unwrap()];
        assert!(close(&scored["network"]["relative_rmse"], &before["relative_rmse"]["unseen"]), "{scored}");
        assert!(close(&scored["network"]["r2"], &before["r2"]["unseen"]), "{scored}");
        assert!(close(&scored["strain_only"]["r2"], &before["r2"]["strain_only"]), "{scored}");
        // Baselines are kept with the study.
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
    let text = done(here, &["evaluate", "study", "run-1", "run-2"]);
    assert!(text.contains("run-2 (seed 2)") && text.contains("relative RMSE"), "{text}");
    assert!(text.contains("ridge, strain only") && text.contains("mean curve"), "{text}");
    // The run that was trained on is no other unseen run.
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

    // A training that was ended before its last file goes on, to the same networks.
    std::fs::remove_file(here.join("study/study.json")).unwrap();
    std::fs::remove_file(here.join("study/F3-2.json")).unwrap();
    let again = done_json(here, &train);
    assert_eq!(again["mappings"]["F3"]["relative_rmse"], trained["mappings"]["F3"]["relative_rmse"]);

    one_row(here);
    many_rows(here);

    // The default trainer knows how sure it is.
    done(here, &["train", "run-1", "--form", "histogram", "--out", "sure"]);
    let ask =
        ["predict", "sure", "-m", "F4", "-s", "deviator_strain=0.1", "-s", "deviator_fabric=0.08", "-s"];
    let answer = done_json(here, &[&ask[..], &["force=1.125"]].concat());
    let deviation = answer["standard_deviation"].as_f64().unwrap();
    assert!(deviation > 0.0 && deviation < 0.5, "{answer}");
}

fn one_row(here: &Path) {
    let inside =
        ["--set", "deviator_strain=0.12", "--set", "force=1.125", "--set", "probability_density=0.4"];
    let mut ask = vec!["predict", "study", "--mapping", "F1"];
    ask.extend(inside);
    let answer = done_json(here, &ask);
    assert_eq!((&answer["sub_model"], &answer["output"]), (&2.into(), &"stress_ratio".into()));
    assert!(answer["standard_deviation"].is_null() && answer["outside"] == serde_json::json!([]), "{answer}");
    let ratio = answer["value"].as_f64().unwrap();
    assert!((0.2..1.2).contains(&ratio), "{ratio}");

    ask[5] = "deviator_strain=0.4";
    let text = done(here, &ask);
    assert!(text.contains("OUTSIDE the trained range: deviator_strain"), "{text}");

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
    assert!(message.contains("\"much\" is not a finite number"), "{message}");
    let message = refused(here, 1, &["predict", "study", "--mapping", "F9"]);
    assert!(message.contains("no mapping `F9`; there are: F1, F2"), "{message}");
}

fn many_rows(here: &Path) {
    let rows =
        "id,deviator_strain,force,probability_density\n1,0.12,1.125,0.4\n2,0.05,0.625,0.5\n3,0.5,1.0,0.4\n";
    std::fs::write(here.join("rows.csv"), rows).unwrap();
    let ask = ["predict", "study", "--mapping", "F1", "--input", "rows.csv", "-o", "answers.csv"];
    let told = done_json(here, &ask);
    assert_eq!((&told["rows"], &told["rows_outside"]), (&3.into(), &1.into()));
    let table = granum_io::read_table(here.join("answers.csv")).unwrap();
    assert_eq!(table.column("outside").unwrap(), [0.0, 0.0, 1.0]);
    assert_eq!(table.column("sub_model").unwrap(), [2.0, 1.0, 3.0]);
    let ask_one = ["predict", "study", "-m", "F1", "-s", "deviator_strain=0.05", "-s", "force=0.625", "-s"];
    let one = done_json(here, &[&ask_one[..], &["probability_density=0.5"]].concat());
    let same = table.column("predicted_stress_ratio").unwrap()[1];
    assert!((one["value"].as_f64().unwrap() - same).abs() < 1e-12);

    assert!(refused(here, 1, &ask).contains("answers.csv exists already"));
    std::fs::write(here.join("rows.csv"), rows.replace("0.625", "many")).unwrap();
    let message = refused(here, 1, &ask[..6]);
    assert!(message.contains("rows.csv:3:"), "{message}");
    std::fs::write(here.join("rows.csv"), rows.replace(",force", ",farce")).unwrap();
    let message = refused(here, 1, &ask[..6]);
    assert!(message.contains("force") && message.contains("rows.csv"), "{message}");
}

#[test]
fn what_cannot_be_trained_is_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    make_run(here, 1);
    let message = refused(here, 1, &["train", "run-1", "--unseen", "./run-1"]);
    assert!(message.contains("run-1 and ./run-1 are the same run"), "{message}");
    let message = refused(here, 1, &["train", "run-1", "--trainer", "adam"]);
    assert!(message.contains("adam") && message.contains("traingdx"), "{message}");
    let message = refused(here, 1, &["train", "run-1", "--epoch-factor", "0.1"]);
    assert!(message.contains("only traingdx has the epochs"), "{message}");
    let message = refused(here, 1, &["train", "run-1", "--trainer", "traingdx", "--epoch-factor", "-1"]);
    assert!(message.contains("more than 0"), "{message}");
    let message = refused(here, 1, &["evaluate", "run-1", "run-1"]);
    assert!(message.contains("study.json"), "{message}");
    std::fs::write(here.join("run-1/series.parquet"), "PAR1").unwrap();
    let message = refused(here, 1, &["train", "run-1"]);
    assert!(message.contains("series.parquet"), "{message}");
    assert!(!here.join("study").exists());
}
