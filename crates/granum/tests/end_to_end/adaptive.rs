//! A campaign whose runs are chosen batch after batch, and the questions to data.

use std::path::Path;

use crate::campaigns::folder_with_plan;
use crate::networks::make_run_of;
use crate::{done, done_json, refused};

/// Twelve points of a sequence in friction and pressure; the runs are far too fast, which the plan accepts.
const PLAN: &str = "case = 'sand.toml'\naccept = ['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', \
                    'unbalanced_force < 10', 'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1']\n\
                    [design]\nkind = 'sobol'\npoints = 12\n\
                    sample_seeds = 'different'\n[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\nfrom = 0.1\nto = 0.8\n\
                    [[variable]]\nname = 'pressure'\nkeys = ['preparation.mean_stress', 'stage.1.lateral_stress']\nfrom = '90 kPa'\n\
                    to = '110 kPa'\nscale = 'log'\n";

const ASKED: [&str; 8] =
    ["campaign", "plan.toml", "--adaptive", "gaussian-process", "--first", "6", "--batch", "3"];

fn numbers(folder: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(folder.join("adaptive.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    file["points"].as_array().unwrap().iter().map(|point| point.as_u64().unwrap()).collect()
}

/// The runs are chosen where they tell most, the same again whatever interrupted the campaign, and each point once.
#[test]
fn runs_are_chosen_batch_after_batch() {
    let base = folder_with_plan();
    let here = base.path();
    std::fs::write(here.join("plan.toml"), PLAN).unwrap();
    let told = done_json(here, &[&ASKED[..], &["--out", "whole", "--workers", "1"]].concat());
    assert_eq!((&told["finished"], &told["data_set"]["runs"]), (&12.into(), &12.into()), "{told}");
    let whole = numbers(&here.join("whole"));
    assert_eq!(whole[..6], [0, 1, 2, 3, 4, 5]);
    assert!(whole[6..] != [6, 7, 8, 9, 10, 11], "{whole:?}");
    let mut sorted = whole.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), 12);

    // With fewer points first, on other workers, the choice and the bytes are the same.
    std::fs::write(here.join("plan.toml"), PLAN.replace("points = 12", "points = 9")).unwrap();
    done(here, &[&ASKED[..], &["--out", "parts", "--workers", "2"]].concat());
    assert_eq!(numbers(&here.join("parts")), whole[..9]);
    assert!(done(here, &["resume", "parts"]).contains("already finished"));
    std::fs::write(here.join("plan.toml"), PLAN).unwrap();
    let again = done_json(here, &[&ASKED[..], &["--out", "parts"]].concat());
    assert_eq!(numbers(&here.join("parts")), whole);
    assert_eq!(again["data_set"]["digest"], told["data_set"]["digest"]);

    let other = refused(here, 1, &[&ASKED[..7], &["5", "--out", "parts"]].concat());
    assert!(other.contains("--first 6 --batch 3"), "{other}");
    std::fs::write(here.join("plan.toml"), PLAN.replace("sobol", "latin-hypercube")).unwrap();
    let other = refused(here, 1, &[&ASKED[..], &["--out", "other"]].concat());
    assert!(other.contains("kind sobol only"), "{other}");
    let other = refused(here, 2, &["campaign", "plan.toml", "--batch", "3"]);
    assert!(other.contains("--adaptive"), "{other}");
}

/// Every question is answered for small runs, with one line for each answer.
#[test]
fn data_are_examined() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let names: Vec<String> = (1..=9).map(|k| format!("run-{k}")).collect();
    for (k, name) in names.iter().enumerate() {
        make_run_of(here, name, |case| {
            let case = case
                .replace("count = 150", "count = 80")
                .replace("deviator_strain = 0.3", "deviator_strain = 0.05")
                .replace("states = 40", "states = 20");
            format!("{case}\n[grains.material]\nfriction = 0.{}\n", k + 1)
                .replace("[preparation]", &format!("[preparation]\nseed = {k}"))
        });
    }
    let learned: Vec<&str> = names[..7].iter().map(String::as_str).collect();
    let examined = |question: &str, more: &[&str]| {
        let words = [&["examine", question][..], &learned, &["--unseen", "run-8", "run-9"], more].concat();
        done_json(here, &words)["answers"].as_array().unwrap().clone()
    };
    let errors = |answers: &[serde_json::Value]| {
        answers
            .iter()
            .all(|own| own["error"]["relative"].as_f64().is_some_and(|error| error > 0.0 && error < 5.0))
    };
    let order = examined("order", &["--runs", "5,7", "--batch", "1", "--orders", "1"]);
    assert!(order.len() == 4 * 2 * 2 && errors(&order), "{order:?}");
    let noise = examined("noise", &["--input", "deviator_fabric", "--method", "ridge", "--level", "0,0.5"]);
    assert!(noise.len() == 2 * 3 * 2 && errors(&noise), "{noise:?}");
    let components =
        examined("components", &["--method", "ridge", "--count", "1,2", "--output", "stress_ratio"]);
    assert!(components.len() == 5 && errors(&components), "{components:?}");
    let curves = examined("components", &["--curves", "--count", "2"]);
    assert!(curves.len() == 4 && errors(&curves), "{curves:?}");
    let refusal = refused(here, 1, &["examine", "order", "run-1", "run-2"]);
    assert!(refusal.contains("--unseen"), "{refusal}");

    let told = done(here, &["examine", "map", "run-1", "run-9", "--cells", "6x4", "-o", "map.svg"]);
    assert!(told.contains("2 runs on 6 x 4 cells"), "{told}");
    let svg = std::fs::read_to_string(here.join("map.svg")).unwrap();
    assert!(svg.contains("sliding fraction") && svg.contains("states in a cell"));
    let refusal = refused(here, 1, &["examine", "map", "run-1", "-o", "map.png"]);
    assert!(refusal.contains(".svg or .json"), "{refusal}");
}
