//! End-to-end tests of the program as a user runs it: small simulations, networks that are trained on them, and inputs that
//! are refused.

mod adaptive;
mod any_path;
mod bonds;
mod bounds_of_use;
mod calibrations;
mod campaign_chapter;
mod campaigns;
mod changed;
mod chapter;
mod columns;
#[path = "../common/mod.rs"]
mod common;
mod comparisons;
mod data_sets;
mod escape;
mod example_grains;
mod families_chapter;
mod family_questions;
mod further_sensors;
mod hostile_plans;
mod inputs;
mod lammps_bonds;
mod lammps_clumps;
mod lammps_decks;
mod lammps_engine;
mod materials;
mod mechanics;
mod mixed;
#[cfg(unix)]
mod moved_folders;
#[cfg(unix)]
mod moved_studies;
mod names;
mod networks;
mod nothing_lost;
mod one_kind_of_test;
mod packings;
mod recordings;
mod refusals;
mod saved_runs;
mod sensors_of_bodies;
#[cfg(unix)]
mod served;
mod settings;
mod several_runs;
mod shapes;
mod sixteen_cases;
mod stages;
mod streams_of_states;
mod tables;
mod tables_of_others;
mod tests_of_grains;
mod tutorial;
mod unexplained;
mod view;
mod warnings;
mod words;
#[cfg(unix)]
mod workflows;
mod worth;

use std::path::Path;

use common::{json, run, stderr, stdout};
use serde_json::Value;

/// A case whose preparation and shear take one or two seconds.
pub const SMALL: &str = r#"
[grains]
count = 150
[preparation]
friction = 0.1
solid_fraction = "none"
inertial_number = 5e-3
unbalanced_force = 1e-2
[shear]
deviator_strain = 0.02
inertial_number = 3e-3
[recording]
states = 8
observations_per_state = 3
"#;

/// Runs granum, which must succeed, and returns its standard output.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "granum {}: {}", arguments.join(" "), stderr(&output));
    stdout(&output)
}

/// Runs granum with `--json`, which must succeed, and returns its output.
pub fn done_json(folder: &Path, arguments: &[&str]) -> Value {
    let mut all = vec!["--json"];
    all.extend(arguments);
    json(&done(folder, &all))
}

/// Runs granum, which must fail with the given status, and returns its standard error.
pub fn refused(folder: &Path, status: i32, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(status), "granum {}: {}", arguments.join(" "), stderr(&output));
    stderr(&output)
}

/// The digest of a run folder.
pub fn digest(folder: &Path, name: &str) -> String {
    let digests = done_json(folder, &["digest", name]);
    let digest = digests["digests"][0]["sha256"].as_str().unwrap().to_string();
    assert_eq!(digest.len(), 64);
    digest
}
