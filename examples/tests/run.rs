//! Runs all examples.

#[path = "../clumps.rs"]
mod clumps;
#[path = "../compare_surrogates.rs"]
mod compare_surrogates;
#[path = "../draw_a_figure.rs"]
mod draw_a_figure;
#[path = "../many_runs.rs"]
mod many_runs;
#[path = "../material_point.rs"]
mod material_point;
#[path = "../measure_a_packing.rs"]
mod measure_a_packing;
#[path = "../own_contact_law.rs"]
mod own_contact_law;
#[path = "../own_packing_format.rs"]
mod own_packing_format;
#[path = "../parameter_study.rs"]
mod parameter_study;
#[path = "../rolling_resistance.rs"]
mod rolling_resistance;
#[path = "../several_materials.rs"]
mod several_materials;
#[path = "../shear_a_sample.rs"]
mod shear_a_sample;
#[path = "../step_by_hand.rs"]
mod step_by_hand;
#[path = "../stop_and_continue.rs"]
mod stop_and_continue;
#[path = "../train_and_ask.rs"]
mod train_and_ask;
#[path = "../triaxial_paths.rs"]
mod triaxial_paths;

#[test]
fn shear_a_sample_runs() {
    shear_a_sample::main().unwrap();
}

#[test]
fn material_point_runs() {
    material_point::main().unwrap();
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
fn clumps_runs() {
    clumps::main().unwrap();
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

#[test]
fn draw_a_figure_runs() {
    draw_a_figure::main().unwrap();
}

#[test]
fn parameter_study_runs() {
    parameter_study::main().unwrap();
}

#[test]
fn several_materials_runs() {
    several_materials::main().unwrap();
}

#[test]
fn stop_and_continue_runs() {
    stop_and_continue::main().unwrap();
}
