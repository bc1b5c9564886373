//! The quality flags that runs of several engines have, with their limits and advice.

use granum_io::run::QualityFlag;

/// Largest ratio of overlap to the sum of the radii for which the theory of small contacts holds.
pub(super) const LARGEST_OVERLAP: f64 = 0.02;
/// Largest mean inertial number of a quasi-static test.
pub(super) const LARGEST_INERTIAL_NUMBER: f64 = 1.05e-3;
/// Largest mean unbalanced force of a quasi-static test.
const LARGEST_UNBALANCED_FORCE: f64 = 0.05;

/// Number of stages that met none of their end conditions.
pub(super) fn stages_cut_short(count: usize) -> QualityFlag {
    let advice = "a stage met none of its end conditions; the reason why it ended is in the notes of the run";
    QualityFlag::at_most("stages_cut_short", count as f64, 0.0, advice)
}

/// The mean inertial number and the mean unbalanced force of a test; `speed_key` is what sets its speed in the case.
pub(super) fn quasi_static(inertial_number: f64, unbalanced_force: f64, speed_key: &str) -> [QualityFlag; 2] {
    [
        QualityFlag::at_most(
            "inertial_number",
            inertial_number,
            LARGEST_INERTIAL_NUMBER,
            format!("the test is too fast to be quasi-static; lower {speed_key}"),
        ),
        QualityFlag::at_most(
            "unbalanced_force",
            unbalanced_force,
            LARGEST_UNBALANCED_FORCE,
            format!("grains are far from equilibrium; lower {speed_key}"),
        ),
    ]
}

/// The root mean square error of the controlled stress over the mean stress.
pub(super) fn servo_error(error: f64, limit: f64, speed_key: &str) -> QualityFlag {
    let advice =
        format!("the controlled stress fluctuates about its target; lower {speed_key} or take more grains");
    QualityFlag::at_most("servo_error_rms", error, limit, advice)
}

/// The largest overlap of a sample or a test.
pub(super) fn overlap(name: impl Into<String>, largest: f64) -> QualityFlag {
    let advice =
        "overlaps are too large for the theory of small contacts; lower the stress or raise Young's modulus";
    QualityFlag::at_most(name, largest, LARGEST_OVERLAP, advice)
}

/// The time step as a fraction of the period of the stiffest contact.
pub(super) fn time_step(name: impl Into<String>, fraction: f64, limit: f64) -> QualityFlag {
    let advice = "the time step exceeds the stability limit of a grain with twelve stiff contacts; lower numerics.time_step_factor";
    QualityFlag::at_most(name, fraction, limit, advice)
}
