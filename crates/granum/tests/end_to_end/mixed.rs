//! Runs that differ in more than their seed, and scores on runs that a study has used for training.

use std::path::Path;

use crate::common::{json, run, stderr, stdout};
use crate::networks::{make_run, make_run_of};
use crate::{done, done_json, refused};

const QUICK: [&str; 4] = ["--trainer", "traingdx", "--epoch-factor", "2e-4"];

fn train<'a>(words: &[&'a str]) -> Vec<&'a str> {
    [&["train"], words, &QUICK].concat()
}

/// Two runs of one test with different seeds, and a test with another friction and another final strain.
fn make_runs(here: &Path) {
    make_run(here, 1);
    make_run(here, 2);
    make_run_of(here, "other", |case| {
        format!(
            "{}[grains.material]\nfriction = 0.5\n",
            case.replace("deviator_strain = 0.3", "deviator_strain = 0.25")
        )
    });
}

#[test]
fn runs_that_differ_in_more_than_the_seed_are_refused_or_called_so() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    make_runs(here);
    for words in
        [&["run-1", "other", "--out", "study"][..], &["run-1", "--unseen", "other", "--out", "study"]]
    {
        let message = refused(here, 1, &train(words));
        for part in [
            "grains.material.friction: 0.3 in run-1; 0.5 in other",
            "shear.deviator_strain: 0.3 in run-1; 0.25 in other",
            "--mixed",
        ] {
            assert!(message.contains(part), "{message}");
        }
        assert!(!message.contains("preparation.seed:") && !here.join("study").exists(), "{message}");
    }

    // With --mixed they are accepted, and the keys that differ are printed.
    let words = train(&["run-1", "--unseen", "run-2", "other", "--mixed", "--out", "mixed"]);
    let text = done(here, &words);
    let said = "difference between runs (seed, grains.material.friction and shear.deviator_strain)";
    assert!(text.contains(said) && !text.contains("seed scatter"), "{text}");
    // A resumed training retains the option --mixed.
    std::fs::remove_file(here.join("mixed/study.json")).unwrap();
    let resumed = done(here, &["resume", "mixed"]);
    assert!(resumed.contains(said), "{resumed}");
    let told = done_json(here, &[&words[..], &["--force"]].concat());
    let keys = json(r#"["preparation.seed","grains.material.friction","shear.deviator_strain"]"#);
    assert_eq!(told["runs_differ_in"], keys);
    assert!(told["mappings"]["F1"]["run_difference"].is_number(), "{told}");
    assert!(told["mappings"]["F1"]["seed_scatter"].is_null(), "{told}");

    // For runs that differ only in their seed, the spread is called seed scatter.
    let told = done_json(here, &train(&["run-1", "--unseen", "run-2", "--out", "study"]));
    assert_eq!(told["runs_differ_in"], json(r#"["preparation.seed"]"#));
    assert!(told["mappings"]["F1"]["seed_scatter"].is_number(), "{told}");
    evaluations(here);
}

/// Scores are labelled by the relation of the run to the training runs.
fn evaluations(here: &Path) {
    let evaluate = |words: &[&str]| {
        let output = run(here, &[&["evaluate", "study"], words].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        (stdout(&output), stderr(&output))
    };
    // A copy of the training run under another name is recognised as the training run.
    copy(&here.join("run-1"), &here.join("copy"));
    for name in ["run-1", "copy"] {
        let (text, warned) = evaluate(&[name]);
        assert!(text.contains(&format!("{name} (seed 1): scores on a training run")), "{text}");
        assert!(warned.contains("trained on every second state of this run"), "{warned}");
    }
    let (text, warned) = evaluate(&["run-2"]);
    assert!(
        text.contains("run-2 (seed 2): scores on an unseen run\n") && warned.is_empty(),
        "{text}{warned}"
    );
    let (text, warned) = evaluate(&["other"]);
    assert!(text.contains("unseen run of another case"), "{text}");
    assert!(warned.contains("grains.material.friction is 0.5, trained at 0.3"), "{warned}");
    let told = done_json(here, &["evaluate", "study", "run-1", "run-2", "other"]);
    let kinds: Vec<&str> = (0..3).map(|k| told["runs"][k]["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds[..2], ["scores on a training run", "scores on an unseen run"]);
    let found = &told["runs"][2]["differs_from_training"][0];
    assert_eq!(found, &json(r#"{"key":"grains.material.friction","value":"0.5","trained":["0.3"]}"#));
    // A value is not new if one of the training runs has it.
    let told = done_json(here, &["evaluate", "mixed", "run-2"]);
    assert_eq!(told["runs"][0]["differs_from_training"], json("[]"));

    // A study in the format of earlier versions is refused with its version.
    let old = r#"{"format": "granum study", "version": 3, "form": "point", "sha256": "0"}"#;
    std::fs::write(here.join("study/study.json"), old).unwrap();
    for command in [&["evaluate", "study", "run-1"][..], &["predict", "study"], &["status", "study"]] {
        let message = crate::refused(here, 1, command);
        assert!(message.contains("version 3 of an earlier format"), "{command:?}: {message}");
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in
        std::fs::read_dir(from).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file())
    {
        std::fs::copy(&entry, to.join(entry.file_name().unwrap())).unwrap();
    }
}
