//! The quality checks of the standard engines, by name: a plan of runs says of which checks it takes larger values.

/// The names of the checks that the standard engines make of samples and tests.
pub const CHECKS: [&str; 20] = [
    "sample_unbalanced_force",
    "sample_mean_stress_missed_by",
    "sample_largest_overlap",
    "sample_time_step_fraction",
    "consolidation_unbalanced_force",
    "consolidation_mean_stress_missed_by",
    "consolidation_largest_overlap",
    "consolidation_time_step_fraction",
    "solid_fraction_missed_by",
    "stages_cut_short",
    "inertial_number",
    "unbalanced_force",
    "servo_error_rms",
    "servo_error_largest",
    "largest_overlap",
    "momentum_drift",
    "time_step_fraction",
    "mean_stress_lost",
    "energy_gap",
    "stress_differs_from_lammps",
];
