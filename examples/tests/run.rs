//! Runs all examples.

#[path = "../compare_surrogates.rs"]
mod compare_surrogates;
#[path = "../many_runs.rs"]
mod many_runs;
#[path = "../measure_a_packing.rs"]
mod measure_a_packing;
#[path = "../own_contact_law.rs"]
mod own_contact_law;
#[path = "../own_packing_format.rs"]
mod own_packing_format;
#[path = "../rolling_resistance.rs"]
mod rolling_resistance;
#[path = "../shear_a_sample.rs"]
mod shear_a_sample;
#[path = "../step_by_hand.rs"]
mod step_by_hand;
#[path = "../train_and_ask.rs"]
mod train_and_ask;
#[path = "../triaxial_paths.rs"]
mod triaxial_paths;

#[test]
fn shear_a_sample_runs() {
    shear_a_sample::main().unwrap();
}

#[test]
fn triaxial_paths_runs() {
    triaxial_paths::main().unwrap();
}

#[test]
fn many_runs_runs() {
    many_runs::main().unwrap();
}

#[test]
fn rolling_resistance_runs() {
    rolling_resistance::main().unwrap();
}

#[test]
fn step_by_hand_runs() {
    step_by_hand::main().unwrap();
}

#[test]
fn measure_a_packing_runs() {
    measure_a_packing::main().unwrap();
}

#[test]
fn own_contact_law_runs() {
    own_contact_law::main().unwrap();
}

#[test]
fn own_packing_format_runs() {
    own_packing_format::main().unwrap();
}

#[test]
fn compare_surrogates_runs() {
    compare_surrogates::main().unwrap();
}

#[test]
fn train_and_ask_runs() {
    train_and_ask::main().unwrap();
}
