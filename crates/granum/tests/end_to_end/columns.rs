//! Studies of any columns: trained, evaluated, asked, reported and resumed by the program.

use std::path::Path;

use serde_json::Value;

use crate::networks::{make_run, make_run_of};
use crate::{SMALL, done, done_json, refused};

const TRAIN: [&str; 14] = [
    "train",
    "run-1",
    "run-2",
    "--unseen",
    "run-3",
    "run-4",
    "--input",
    "deviator_fabric",
    "--output",
    "stress_ratio,coordination_number",
    "--coordinate",
    "deviator_strain",
    "--method",
    "ridge",
];

fn train(here: &Path, out: &str) -> Value {
    done_json(here, &[&TRAIN[..], &["-o", out]].concat())
}

fn error(scores: &Value) -> f64 {
    scores["score"]["relative_rmse"].as_f64().unwrap()
}

#[test]
fn a_study_of_columns_is_trained_judged_asked_reported_and_resumed() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    (1..=4).for_each(|seed| make_run(here, seed));
    let trained = train(here, "study");
    let fits = trained["fits"].as_array().unwrap();
    assert_eq!((fits.len(), &fits[0]["name"]), (2, &"stress_ratio".into()));
    let members = fits[0]["members"].as_array().unwrap();
    let names: Vec<&str> = members.iter().map(|member| member["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["stress_ratio-ridge", "stress_ratio-ridge-coordinate-only", "stress_ratio-mean-curve"]
    );
    assert!(error(&members[0]["training"]) > 0.0 && error(&members[0]["unseen"]) < 0.5, "{trained}");
    let used = &fits[0]["uses"]["stress_ratio-ridge"];
    assert_eq!(used["verdict"], "cannot be told from so few runs");
    assert!(used["with_other"]["relative_rmse"].is_number() && used["help"]["mean"].is_number(), "{used}");
    let message = refused(here, 1, &[&TRAIN[..], &["-o", "study"]].concat());
    assert!(message.contains("study already contains a finished training"), "{message}");

    // The scores of the files over both unseen runs are those at the end of training.
    let judged = done_json(here, &["evaluate", "study", "run-3", "run-4"]);
    let one = |run: usize| judged["runs"][run]["surrogates"][0]["scores"]["score"]["rmse"].as_f64().unwrap();
    let both = (0.5 * (one(0).powi(2) + one(1).powi(2))).sqrt();
    assert!((both / members[0]["unseen"]["score"]["rmse"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{judged}");
    assert_eq!(judged["uses"]["stress_ratio-ridge"]["with_other"], used["with_other"]);
    let text = done(here, &["evaluate", "study", "run-1"]);
    assert!(text.contains("scores on a training run") && text.contains("stress_ratio-mean-curve"), "{text}");

    // One surrogate is asked by its name in the study or by its file.
    let question = ["-s", "deviator_strain=0.1", "-s", "deviator_fabric=0.1"];
    let by_name = [&["predict", "study", "--model", "stress_ratio-ridge"], &question[..]].concat();
    let by_file = [&["predict", "study/stress_ratio-ridge.json"], &question[..]].concat();
    let predicted = done_json(here, &by_name);
    assert_eq!(predicted, done_json(here, &by_file));
    assert!(predicted["outputs"][0]["lower"].is_number(), "{predicted}");
    let message = refused(here, 1, &["predict", "study"]);
    assert!(
        message.contains("--model NAME") && message.contains("coordination_number-mean-curve"),
        "{message}"
    );

    done(here, &["report", "study"]);
    let page = std::fs::read_to_string(here.join("study/report.html")).unwrap();
    assert!(page.contains("Use of the inputs") && page.contains("mean-curve") && !page.contains("NaN"));
    assert!(here.join("study/figures/figure-s1-along.svg").is_file());

    // Without its last files the training is unfinished, and goes on to the same bytes.
    std::fs::remove_file(here.join("study/study.json")).unwrap();
    std::fs::remove_file(here.join("study/stress_ratio-mean-curve.json")).unwrap();
    let status = done_json(here, &["status", "study"]);
    assert_eq!((&status["surrogates"], &status["surrogates_end"]), (&5.into(), &6.into()), "{status}");
    let other = [&TRAIN[..12], &["--method", "mean-curve", "-o", "study"]].concat();
    assert!(refused(here, 1, &other).contains("differs in the methods"));
    done(here, &["resume", "study"]);
    train(here, "again");
    for name in ["study.json", "stress_ratio-mean-curve.json", "predictions.csv"] {
        let bytes = |folder: &str| std::fs::read(here.join(folder).join(name)).unwrap();
        assert_eq!(bytes("study"), bytes("again"), "{name}");
    }
    std::fs::write(here.join("study/predictions.csv"), "altered").unwrap();
    assert!(refused(here, 1, &["evaluate", "study", "run-3"]).contains("its SHA-256 is not the one"));
}

/// Networks for two ranges of the strain, from fewer states than there are, with a learning curve.
#[test]
fn sub_models_and_a_learning_curve_of_any_columns() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    (1..=4).for_each(|seed| make_run(here, seed));
    let train = |flags: &[&'static str]| -> Vec<&'static str> {
        let line = "train run-1 run-2 --unseen run-3 run-4 --input deviator_fabric --output stress_ratio --coordinate \
                    deviator_strain --hidden 3 --most-states 20";
        line.split_whitespace().chain(flags.iter().copied()).collect()
    };
    let parts = train(&[
        "--sub-models",
        "0.1",
        "--learning-curve",
        "--trainer",
        "levenberg-marquardt",
        "-o",
        "parts",
    ]);
    let trained = done_json(here, &parts);
    let fit = &trained["fits"][0];
    let member = &fit["members"][0];
    assert_eq!(member["name"], "stress_ratio-sub-models");
    let networks = member["networks"].as_array().unwrap();
    assert_eq!(
        (networks.len(), &networks[0]["range"][1], &networks[0]["hidden"]),
        (2, &0.1.into(), &serde_json::json!([3]))
    );
    assert!(networks[0]["rows"].as_u64().unwrap() <= 20, "{member}");
    let whole: u64 = networks.iter().map(|network| network["unseen"]["states"].as_u64().unwrap()).sum();
    assert_eq!(Some(whole), member["unseen"]["score"]["states"].as_u64());
    // All four runs differ only in their seed.
    assert_eq!(
        (&fit["seed_scatter"]["groups"], &fit["seed_scatter"]["runs"]),
        (&1.into(), &4.into()),
        "{fit}"
    );
    let points = trained["learning_curve"]["points"].as_array().unwrap();
    let runs: Vec<_> = points.iter().map(|point| (&point["training_runs"], &point["sets"])).collect();
    assert_eq!(runs, [(&1.into(), &2.into()), (&2.into(), &1.into())]);
    // The last point is the study itself.
    let mean = points[1]["error"]["mean"].as_f64().unwrap();
    let own = fit["uses"]["stress_ratio-sub-models"]["own"]["relative_rmse"].as_f64().unwrap();
    assert!((mean / own - 1.0).abs() < 0.2, "{mean} {own}");

    done(here, &["report", "parts"]);
    let page = std::fs::read_to_string(here.join("parts/report.html")).unwrap();
    for words in
        ["Number of training runs", "each for a range of deviator_strain", "differ only in their seed"]
    {
        assert!(page.contains(words), "{words}");
    }
    // Without the surrogate and the last file the training goes on, to the same bytes.
    let kept = std::fs::read(here.join("parts/study.json")).unwrap();
    for name in ["study.json", "stress_ratio-sub-models.json"] {
        std::fs::remove_file(here.join("parts").join(name)).unwrap();
    }
    let text = done(here, &["resume", "parts"]);
    assert!(
        text.contains("stress_ratio-sub-models sub-model 2 (0.1 to") && text.contains("learning curve"),
        "{text}"
    );
    assert!(text.contains("runs that differ only in their seed scatter by"), "{text}");
    assert_eq!(std::fs::read(here.join("parts/study.json")).unwrap(), kept);

    let refuse = |code: i32, flags: &[&'static str]| refused(here, code, &train(flags));
    assert!(refuse(1, &["--sub-models", "0.9", "-o", "out"]).contains("sub-models meet in between"));
    assert!(refuse(1, &["--sub-models", "0.2,0.1", "-o", "out"]).contains("must increase"));
    assert!(
        refuse(1, &["--sub-models", "0.1", "--method", "ridge", "-o", "out"]).contains("--method sub-models")
    );
    assert!(refuse(1, &["--sub-models", "0.1,0.1001", "-o", "out"]).contains("needs 3; record more states"));
    assert!(refuse(1, &["--trainer", "none", "-o", "out"]).contains("levenberg-marquardt"));
    assert!(!here.join("out").exists());
}

/// Runs that differ in their friction, which is an input.
#[test]
fn a_parameter_of_the_case_is_an_input_and_bad_columns_are_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    for (name, friction) in [("low", "0.2"), ("middle", "0.3"), ("high", "0.4")] {
        make_run_of(here, name, |case| {
            case.replace("[grains]\n", &format!("[grains]\nmaterial.friction = {friction}\n"))
        });
    }
    let train = |flags: &[&str]| -> Vec<String> {
        ["train", "low", "high", "--unseen", "middle", "-o", "out"]
            .iter()
            .chain(flags)
            .map(ToString::to_string)
            .collect()
    };
    let refuse = |flags: &[&str]| {
        let line = train(flags);
        let message = refused(here, 1, &line.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(!here.join("out").exists(), "{message}");
        message
    };
    let along =
        ["--coordinate", "deviator_strain", "--output", "stress_ratio", "--method", "ridge", "--input"];
    let with = |input: &'static str| [&along[..], &[input]].concat();
    let line = train(&with("grains.material.friction"));
    let trained = done_json(here, &line.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(trained["warnings"].is_null() || trained["warnings"].as_array().unwrap().is_empty(), "{trained}");
    std::fs::remove_dir_all(here.join("out")).unwrap();

    assert!(refuse(&with("stress_ration")).contains("did you mean stress_ratio?"));
    assert!(refuse(&with("stress_ratio")).contains("stress_ratio is both an input and an output"));
    let message = refuse(&with("contact.normal"));
    assert!(message.contains("the input contact.normal is jkr in all training runs"), "{message}");
    let message = refuse(&with("grains.count"));
    assert!(message.contains("in all training states") && message.contains("leave it out"), "{message}");
    let message = refuse(&["--input", "deviator_strain", "--output", "stress_ratio", "--method", "rigde"]);
    assert!(
        message.contains("no surrogate method `rigde`") && message.contains("did you mean ridge?"),
        "{message}"
    );
    let one = ["train", "low", "--input", "deviator_strain", "--output", "stress_ratio", "-o", "out"];
    assert!(refused(here, 1, &one).contains("needs two or more runs"));
    let without = ["train", "low", "high", "--input", "deviator_strain", "-o", "out"];
    assert!(refused(here, 2, &without).contains("--output"));
    let both = [&one[..], &["--epoch-factor", "0.5"]].concat();
    assert!(refused(here, 2, &both).contains("cannot be used with"));
}

/// Words of the case, measures of the sample, and bins of any histogram are columns; a surrogate is asked with the word.
#[test]
fn words_samples_and_every_histogram_are_columns() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let case = SMALL
        .replace("count = 150", "count = 100")
        .replace("[recording]", "[recording]\nsensors = ['overlap_distribution']");
    std::fs::write(here.join("case.toml"), case).unwrap();
    for (name, law, seed) in
        [("slip", "mindlin-deresiewicz", 1), ("stick", "no-slip", 2), ("new", "no-slip", 3)]
    {
        let [law, seed] = [format!("contact.tangential={law}"), format!("preparation.seed={seed}")];
        done(here, &["shear", "case.toml", "--out", name, "--set", &law, "--set", &seed]);
    }
    done(here, &["export", "slip", "--table", "overlaps", "-o", "overlaps.csv"]);
    let table = granum_io::read_table(here.join("overlaps.csv")).unwrap();
    let names = ["stage", "state", "overlap", "bin_width", "count", "probability_density"];
    assert_eq!(table.names().collect::<Vec<_>>(), names);

    let listed = done_json(here, &["train", "slip", "stick", "--columns"]);
    let meaning = |name: &str| -> String {
        let all = listed["columns"].as_array().unwrap().iter();
        let found = all
            .clone()
            .find(|column| column["name"] == name)
            .unwrap_or_else(|| panic!("no {name}: {listed}"));
        found["meaning"].as_str().unwrap().to_string()
    };
    assert_eq!(meaning("contact.tangential"), "a word, here mindlin-deresiewicz, no-slip");
    assert_eq!(meaning("grains.count"), "100 in all runs");
    assert!(meaning("overlaps_probability_density").contains("density of overlap in 24 bins"));
    assert!(meaning("sample.coordination_number").contains("over all grains"));

    let inputs = "contact.tangential,sample.void_ratio,overlaps_probability_density";
    let outputs = "stress_ratio,overlaps_below,probability_density_0.625";
    let fit =
        ["--coordinate", "deviator_strain", "--method", "ridge", "--input", inputs, "--output", outputs];
    let line = ["train", "slip", "stick", "--unseen", "new", "-o", "study"];
    let trained = done_json(here, &[&line[..], &fit].concat());
    assert_eq!(trained["fits"][2]["name"], "probability_density_0_625");

    let simple =
        ["--input", "contact.tangential", "--output", "stress_ratio", "--coordinate", "deviator_strain"];
    done(
        here,
        &[&["train", "slip", "stick", "--unseen", "new", "-o", "laws", "--method", "ridge"][..], &simple]
            .concat(),
    );
    let ask = |law: &str| {
        let law = format!("contact.tangential={law}");
        ["predict", "laws", "-m", "stress_ratio-ridge", "-s", "deviator_strain=0.01", "-s", &law]
            .map(String::from)
    };
    let predicted = |law: &str| {
        done_json(here, &ask(law).each_ref().map(String::as_str))["outputs"][0]["mean"].as_f64().unwrap()
    };
    let (slip, stick) = (predicted("mindlin-deresiewicz"), predicted("no-slip"));
    assert_ne!(slip, stick);
    let message = refused(here, 1, &ask("rough").each_ref().map(String::as_str));
    assert!(message.contains("it must be mindlin-deresiewicz or no-slip"), "{message}");
    let rows = "contact.tangential,deviator_strain\nno-slip,0.01\nmindlin-deresiewicz,0.01\n";
    std::fs::write(here.join("rows.csv"), rows).unwrap();
    let many =
        ["predict", "laws", "-m", "stress_ratio-ridge", "--input", "rows.csv", "-o", "predictions.csv"];
    done(here, &many);
    let predictions =
        granum_io::read_columns(here.join("predictions.csv"), &["predicted_stress_ratio"]).unwrap();
    assert_eq!(predictions.columns()[0].values, [stick, slip]);
    let other =
        ["train", "slip", "stick", "--unseen", "new", "-o", "none", "--input", "deviator_strain", "--output"];
    let message = refused(here, 1, &[&other[..], &["contact.tangential"]].concat());
    assert!(message.contains("an output must be a number"), "{message}");
}
