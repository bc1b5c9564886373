//! With `--json` the warnings of a command are a list in its JSON, and nothing else is printed.

use std::path::Path;

use serde_json::Value;

use crate::common::{json, run, stderr, stdout};
use crate::{SMALL, done};

/// The JSON of a command that may fail: of its result, or of its error. There is no other output.
fn told(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[arguments, &["--json"]].concat());
    let (result, error) = (stdout(&output), stderr(&output));
    let (json_text, rest) = if output.status.success() { (result, error) } else { (error, result) };
    assert_eq!(rest, "", "{arguments:?}");
    json(&json_text)
}

/// Asserts that one of the warnings contains a text.
fn warned(told: &Value, text: &str) {
    let warnings = told["warnings"].as_array().unwrap_or_else(|| panic!("no list of warnings in {told}"));
    assert!(warnings.iter().any(|warning| warning.as_str().unwrap().contains(text)), "{text}: {warnings:?}");
}

#[test]
fn every_command_that_warns_does_so_in_its_json() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    let threads = "--threads 1000: this machine has";
    warned(&told(here, &["prepare", "case.toml", "--threads", "1000"]), threads);
    // An error names the warnings that came before it.
    let refused = told(here, &["prepare", "case.toml", "--threads", "1000"]);
    assert!(refused["error"]["message"].as_str().unwrap().contains("already contains"), "{refused}");
    warned(&refused, threads);

    let test = told(here, &["shear", "case.toml", "--sample", "sample"]);
    warned(&test, "inertial number is 0.003 and should be at most 0.00105");
    assert_eq!(test["warnings"].as_array().unwrap().len(), 4, "one for each check that failed: {test}");
    assert_eq!(told(here, &["resume", "run"])["warnings"], test["warnings"], "it is finished");
    // A stage that does not reach its end condition.
    let stage = "[[stage]]\nxx = { rate = 1 }\ninertial_number = 1e-2\nuntil = { mean_stress = \"1 Pa\" }\nmost_arc_length = 1e-3\n";
    let (sample, recording) = (SMALL.find("[shear]").unwrap(), SMALL.find("[recording]").unwrap());
    let case = [&SMALL[..sample], &SMALL[recording..], stage].concat().replace("states = 8\n", "");
    std::fs::write(here.join("short.toml"), case).unwrap();
    let short = told(here, &["run", "short.toml", "--sample", "sample", "--out", "short"]);
    warned(&short, "none of its end conditions was met");
    let beyond = ["stiffness", "case.toml", "--sample", "sample", "--at", "0,0.5"];
    warned(&told(here, &beyond), "--at [0.5]: stage 1 of the test ends before");
    warned(&told(here, &["impact", "--speed", "0.09", "--angle", "5"]), "the grains barely separate");
}

#[test]
fn a_command_without_warnings_has_an_empty_list() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    assert_eq!(told(here, &["init"])["warnings"], Value::Array(Vec::new()));
    assert_eq!(told(here, &["impact", "--speed", "0.5"])["warnings"], Value::Array(Vec::new()));
    assert_eq!(told(here, &["impact", "--sped", "0.5"])["warnings"], Value::Array(Vec::new()));
    // The schema is a document of its own.
    assert!(told(here, &["schema"])["warnings"].is_null());
    assert_eq!(json(&done(here, &["schema"])), told(here, &["schema"]));
}
