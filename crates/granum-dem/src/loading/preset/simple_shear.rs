//! Simple shear at constant normal stress: grains move along x in proportion to y, the stress along y is held constant, the
//! other axes are not strained.

use super::{INERTIAL_NUMBER, PathParameter, Preset, STATES, generous, number, stress};
use crate::loading::{Control, Drive, Kinematics, Measure, RecordedStates, Speed, Stage, Until};

pub(super) const PRESET: Preset = Preset {
    name: "simple-shear",
    help: "Simple shear in the plane xy at constant normal stress along y, without strain along x and z.",
    own: PARAMETERS,
    faults: |values| values.zero("shear_strain"),
    stages: |values| {
        let held = Drive::Stress(values.target("normal_stress"));
        let test = shear(values.speed(), held, values.number("shear_strain"), values.states());
        values.consolidation("normal_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("shear_strain", "Shear strain gamma_xy at the end.", 0.3, [1e-6, 1.0]),
    stress("normal_stress", "Stress along y, to which the sample is first consolidated on all three axes."),
    INERTIAL_NUMBER,
    STATES,
];

/// Simple shear in the plane xy, with a given drive of the axis y.
pub(super) fn shear(speed: Speed, normal: Drive, strain: f64, states: usize) -> Stage {
    let fixed = Drive::Fixed;
    let control = Control {
        kinematics: Kinematics::SimpleShear,
        ..Control::new(speed, [fixed, normal, fixed, fixed, fixed, Drive::Rate(1.0)])
    };
    let until = Until::Reaches { measure: Measure::Strain(5), value: strain };
    Stage {
        most_arc_length: generous(strain),
        resets: true,
        ..Stage::new("shear", control, vec![until]).recording(RecordedStates::equal(
            Measure::Strain(5),
            states,
            strain,
        ))
    }
}
