//! Drained triaxial test: axis x is strained, the lateral stresses are held constant.

use super::{INERTIAL_NUMBER, PathParameter, Preset, STATES, any_stress, generous, number};
use crate::loading::{Control, Drive, Measure, RecordedStates, Stage, Until};

pub(super) const PRESET: Preset = Preset {
    name: "drained-triaxial",
    help: "Drained triaxial compression or extension: axis x is strained, the stresses along y and z are held.",
    own: PARAMETERS,
    faults: |values| values.zero("axial_strain"),
    stages: |values| {
        let end = values.number("axial_strain");
        let held = Drive::Stress(values.target("lateral_stress"));
        let fixed = Drive::Fixed;
        let drives = [Drive::Rate(end.signum()), held, held, fixed, fixed, fixed];
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let record = RecordedStates::every(Measure::ArcLength, end.abs() / values.number("states"));
        let test = Stage {
            most_arc_length: generous(end),
            resets: true,
            ..Stage::new("shear", Control::new(values.speed(), drives), vec![until]).recording(record)
        };
        values.consolidation("lateral_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("axial_strain", "Axial strain at the end; negative for extension.", 0.2, [-3.0, 3.0]),
    any_stress(
        "lateral_stress",
        "Stress along y and z, to which the sample is first consolidated on all three axes.",
    ),
    INERTIAL_NUMBER,
    STATES,
];
