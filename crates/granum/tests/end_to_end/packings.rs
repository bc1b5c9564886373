//! Runs from packings: the output describes the actual run, and no key is silently without effect.

use std::path::Path;

use granum_io::{Packing, Run};
use serde_json::Value;

use crate::common::{run, stderr};
use crate::{SMALL, digest, done, done_json, refused};

/// Writes a packing file with the grains of a prepared sample.
fn packing_of_a_sample(here: &Path, name: &str, seed: &str) {
    done(here, &["prepare", "case.toml", "--seed", seed, "--out", &format!("made-{name}")]);
    let assembly = Run::at(here.join(format!("made-{name}"))).unwrap().snapshot("start").unwrap();
    granum_io::write_packing(here.join(name), &Packing::from_assembly(&assembly)).unwrap();
}

/// A packing of grains of two sizes on a lattice so wide that they do not touch.
fn loose(here: &Path, name: &str) {
    let edge = 6.0 * 1.3e-4;
    let mut text = format!(
        "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi={edge:e} yhi={edge:e} zhi={edge:e}\nid,x,y,z,radius\n"
    );
    for k in 0..216usize {
        let at = |n: usize, salt: usize| (n as f64 + 0.4 + 0.02 * ((k * salt) % 11) as f64) * 1.3e-4;
        let radius = if k % 2 == 0 { 5.5e-5 } else { 4.5e-5 };
        text +=
            &format!("{},{:e},{:e},{:e},{radius:e}\n", k + 1, at(k % 6, 3), at(k / 6 % 6, 5), at(k / 36, 7));
    }
    std::fs::write(here.join(name), text).unwrap();
}

fn record(here: &Path, folder: &str) -> Value {
    let text = std::fs::read_to_string(here.join(folder).join("run.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn a_run_from_a_packing_says_whose_grains_it_ran_and_its_digest_covers_them() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    // Number and diameter of the grains in the case differ from those of the packings.
    std::fs::write(here.join("case.toml"), SMALL.replace("count = 150", "count = 120")).unwrap();
    packing_of_a_sample(here, "one.csv", "1");
    packing_of_a_sample(here, "two.csv", "2");
    std::fs::write(
        here.join("other.toml"),
        SMALL.replace("count = 150", "count = 300\ndiameter = \"0.2 mm\"\n[grains.material]\ndensity = 2650"),
    )
    .unwrap();
    let told = done_json(here, &["shear", "other.toml", "--packing", "one.csv", "--out", "a"]);
    assert_eq!(told["packing"]["file_name"], "one.csv");
    assert_eq!(told["seed"], Value::Null);
    done(here, &["shear", "other.toml", "--packing", "two.csv", "--out", "b"]);
    done(here, &["prepare", "other.toml", "--packing", "one.csv", "--out", "sample"]);
    done(here, &["shear", "other.toml", "--sample", "sample", "--out", "c"]);

    let [a, b, c] = ["a", "b", "c"].map(|name| record(here, name));
    let sha = granum_io::run::file_digest(&here.join("one.csv")).unwrap();
    for record in [&a, &c] {
        assert_eq!(record["grains"], 120);
        assert!(record.get("seed").is_none(), "{record}");
        assert_eq!(record["packing"]["sha256"], sha);
        assert_eq!(record["packing"]["grains"], 120);
        assert!((record["packing"]["mean_diameter"].as_f64().unwrap() - 1e-4).abs() < 1e-12);
    }
    assert_eq!(a["case_digest"], c["case_digest"]);
    assert_ne!(a["case_digest"], b["case_digest"]);
    assert_ne!(a["preparation_digest"], b["preparation_digest"]);
    assert_eq!(digest(here, "a"), digest(here, "c"));
    assert_ne!(digest(here, "a"), digest(here, "b"));
    let seeded = done_json(here, &["prepare", "other.toml", "--out", "seeded"]);
    assert_ne!(seeded["case_digest"], a["case_digest"]);

    done(here, &["report", "a"]);
    let page = std::fs::read_to_string(here.join("a/report.html")).unwrap();
    assert!(page.contains("120 grains of one.csv") && page.contains(&sha), "the packing is not named");
    assert!(page.contains("0.1 mm") && !page.contains("300 grains") && !page.contains("; seed"));
    let case = std::fs::read_to_string(here.join("a/case.toml")).unwrap();
    assert!(case.contains("count = 300  # no effect in this run"), "{case}");
    // A sample made from a packing can be resumed and read like any other.
    done(here, &["resume", "a"]);
    done(here, &["status", "c"]);
}

#[test]
fn keys_without_a_part_in_a_run_from_a_packing_are_named_or_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    packing_of_a_sample(here, "packing.csv", "1");
    let ask = |more: &[&str]| {
        let mut all = vec!["prepare", "case.toml", "--packing", "packing.csv", "--out", "s", "--force"];
        all.extend(more);
        let output = run(here, &all);
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let said = ask(&[]);
    assert!(
        said.contains("grains.count = 150 has no effect in this run: its grains are those of packing.csv"),
        "{said}"
    );
    assert!(
        said.contains("preparation.friction = 0.1 has no effect in this run: packing.csv is not compacted"),
        "{said}"
    );
    assert!(!said.contains("grains.spread") && !said.contains("initial_solid_fraction"), "{said}");
    assert!(!ask(&["--set", "preparation.friction=auto"]).contains("preparation.friction"));
    let notes = record(here, "s")["notes"].to_string();
    assert!(notes.contains("grains.count = 150 has no effect"), "{notes}");

    // The packing carries its load, so that its density does not depend on a preparation friction.
    let told = done_json(
        here,
        &[
            "prepare",
            "case.toml",
            "--packing",
            "packing.csv",
            "--out",
            "s",
            "--force",
            "--set",
            "preparation.solid_fraction=0.72",
            "--set",
            "preparation.friction=auto",
        ],
    );
    let flags = told["quality"].as_array().unwrap();
    let missed = flags.iter().find(|flag| flag["name"] == "solid_fraction_missed_by").unwrap();
    assert_eq!(missed["passed"], false);
    let advice = missed["advice"].as_str().unwrap();
    assert!(advice.contains("the packing was not compacted") && !advice.contains("friction"), "{advice}");

    for flags in [&["--seed", "3"][..], &["--set", "grains.count=200"]] {
        let mut all = vec!["shear", "case.toml", "--packing", "packing.csv", "--out", "r"];
        all.extend(flags);
        let message = refused(here, 1, &all);
        assert!(message.contains("has no effect in a run from --packing"), "{message}");
        assert!(!here.join("r").exists());
    }
}

#[test]
fn a_loose_packing_is_compacted_as_the_case_says() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    loose(here, "loose.csv");
    let with = |out: &str, more: &[&str]| {
        let mut all = vec!["prepare", "case.toml", "--packing", "loose.csv", "--out", out];
        all.extend(more);
        done_json(here, &all)
    };
    let measure = |told: &Value, name: &str| told["measures"][name].as_f64().unwrap();
    let slippery = with("slippery", &["--set", "preparation.friction=0"]);
    let rough = with("rough", &["--set", "preparation.friction=1"]);
    let (most, least) = (measure(&slippery, "solid_fraction"), measure(&rough, "solid_fraction"));
    assert!(most > least + 0.01, "{most} {least}");
    assert!((measure(&slippery, "mean_stress") / 20e3 - 1.0).abs() < 0.01);
    assert_eq!(measure(&slippery, "preparation_friction"), 0.0);

    let target = format!("preparation.solid_fraction={}", 0.5 * (most + least));
    let search = [
        "--set",
        "preparation.friction=auto",
        "--set",
        &target,
        "--set",
        "preparation.solid_fraction_tolerance=0.004",
    ];
    let searched = with("searched", &search);
    let reached = measure(&searched, "solid_fraction");
    assert!(measure(&searched, "preparation_trials") >= 2.0, "{searched}");
    assert!((reached - 0.5 * (most + least)).abs() < 0.01, "{reached} {most} {least}");
    // Every trial starts from the packing again, even after an interruption.
    with("often", &[&search[..], &["--checkpoint-every", "0.001"]].concat());
    assert_eq!(digest(here, "often"), digest(here, "searched"));
    let record = record(here, "searched");
    let mean = record["packing"]["mean_diameter"].as_f64().unwrap();
    assert!((mean - 1e-4).abs() < 1e-9 && (record["packing"]["spread"].as_f64().unwrap() - 0.1).abs() < 1e-9);
}
