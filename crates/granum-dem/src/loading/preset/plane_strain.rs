//! Plane strain compression: axis x is strained, axis y does not strain, the stress along z is held.

use super::{INERTIAL_NUMBER, PathParameter, Preset, STATES, generous, number, stress};
use crate::loading::{Control, Drive, Measure, RecordedStates, Stage, Until};

pub(super) const PRESET: Preset = Preset {
    name: "plane-strain",
    help: "Plane strain compression or extension: axis x is strained, axis y does not strain, the stress along z is held.",
    own: PARAMETERS,
    faults: |values| values.zero("axial_strain"),
    stages: |values| {
        let end = values.number("axial_strain");
        let fixed = Drive::Fixed;
        let held = Drive::Stress(values.target("lateral_stress"));
        let control =
            Control::new(values.speed(), [Drive::Rate(end.signum()), fixed, held, fixed, fixed, fixed]);
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let record = RecordedStates::every(Measure::ArcLength, end.abs() / values.number("states"));
        let test = Stage {
            most_arc_length: generous(end),
            resets: true,
            ..Stage::new("shear", control, vec![until]).recording(record)
        };
        values.consolidation("lateral_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("axial_strain", "Strain along x at the end; negative for extension.", 0.2, [-3.0, 3.0]),
    stress("lateral_stress", "Stress along z, to which the sample is first consolidated on all three axes."),
    INERTIAL_NUMBER,
    STATES,
];
