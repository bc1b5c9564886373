//! Unconfined strength of a powder, in the steps of the shear testers of Jenike and of Schulze: the sample is consolidated, sheared to
//! steady flow at the consolidation stress (pre-shear), unloaded, and sheared to failure.
//!
//! In a periodic cell the whole stress is known and can be made zero, so that the unconfined yield strength is measured and not
//! constructed with Mohr circles: the sample fails under an axial stress alone. Both shears are compressions along x, so that the
//! major principal stress has one direction in the consolidation and in the failure, as in a uniaxial tester.

use super::definition::AT_REST;
use super::{INERTIAL_NUMBER, PathParameter, PathParameterDefault, PathValues, Preset, STATES, generous};
use super::{number, stress};
use crate::loading::{Control, Drive, Measure, Ramp, RecordedStates, Speed, Stage, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "unconfined-strength",
    help: "Unconfined yield strength of a powder: consolidation, compression along x to steady flow at the lateral stress \
           (pre-shear), unloading to zero stress, and compression along x without lateral stress until it fails.",
    own: PARAMETERS,
    faults: |_| None,
    stages: |values| {
        let consolidation = values.consolidation(LATERAL).into_iter();
        consolidation
            .chain([pre_shear(values), unloading(values), rest(values), unconfined(values)])
            .collect()
    },
};

/// Key of the lateral stress.
const LATERAL: &str = "lateral_stress";
/// Share of the lateral stress at which the inertial number of the last compression is given: strengths are lower than the
/// stress of the consolidation.
const SHARE_OF_STRENGTH: f64 = 0.05;

/// Bound on the lateral strain rates of the last compression, as a multiple of the axial one.
const LATERAL_SPEED: f64 = 5.0;

const PARAMETERS: &[PathParameter] = &[
    PathParameter {
        default: PathParameterDefault::Value(10e3),
        ..stress(
            LATERAL,
            "Stress along y and z in the pre-shear, to which the sample is first consolidated on all three axes.",
        )
    },
    number("pre_shear_strain", "Axial strain of the pre-shear.", 0.3, [1e-6, 3.0]),
    number("axial_strain", "Axial strain at the end of the unconfined compression.", 0.1, [1e-6, 3.0]),
    PathParameter {
        help: "Speed: inertial number I of the axial strain rate, at the mean stress at the start of the pre-shear, and at a twentieth of \
               the lateral stress in the unconfined compression.",
        ..INERTIAL_NUMBER
    },
    STATES,
];

/// The speed of the path, with an inertial number at a given stress, Pa.
fn speed_at(values: &PathValues, stress: f64) -> Speed {
    match values.speed() {
        Speed::InertialNumber { number, .. } => Speed::InertialNumber { number, at: Some(stress) },
        rate => rate,
    }
}

/// A compression along x with given lateral drives.
fn compression(values: &PathValues, name: &str, speed: Speed, lateral: Drive, strain: f64) -> Stage {
    let fixed = Drive::Fixed;
    let control = Control::new(speed, [Drive::Rate(1.0), lateral, lateral, fixed, fixed, fixed]);
    let until = Until::Reaches { measure: Measure::Strain(0), value: strain };
    let record = RecordedStates::every(Measure::ArcLength, strain / values.number(STATES.key));
    Stage {
        most_arc_length: generous(strain),
        resets: true,
        ..Stage::new(name, control, vec![until]).recording(record)
    }
}

fn pre_shear(values: &PathValues) -> Stage {
    let lateral = Drive::Stress(Target::held(values.number(LATERAL)));
    compression(values, "pre-shear", values.speed(), lateral, values.number("pre_shear_strain"))
}

fn unloading(values: &PathValues) -> Stage {
    let (off, fixed) = (Drive::Stress(Target::ramp(Ramp::To(0.0))), Drive::Fixed);
    let control = Control::new(values.speed(), [off, off, off, fixed, fixed, fixed]);
    Stage::new("unloading", control, vec![Until::RampOver])
}

fn rest(values: &PathValues) -> Stage {
    let (zero, fixed) = (Drive::Stress(Target::held(0.0)), Drive::Fixed);
    let control =
        Control::new(speed_at(values, values.number(LATERAL)), [zero, zero, zero, fixed, fixed, fixed]);
    let control = Control { servo_limit: 1.0, ..control };
    let end = Until::AtRest { unbalanced_force: AT_REST };
    Stage { settling: true, ..Stage::new("rest", control, vec![end]) }
}

fn unconfined(values: &PathValues) -> Stage {
    let speed = speed_at(values, SHARE_OF_STRENGTH * values.number(LATERAL));
    let strain = values.number("axial_strain");
    let mut stage = compression(values, "unconfined", speed, Drive::Stress(Target::held(0.0)), strain);
    stage.control.servo_limit = LATERAL_SPEED;
    // Grains that hold nothing go apart sideways, as fast as the servo lets them.
    stage.most_arc_length = Some(2.0 * LATERAL_SPEED * strain + 0.01);
    stage
}
