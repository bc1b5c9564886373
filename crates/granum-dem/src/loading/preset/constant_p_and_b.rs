//! True triaxial test at constant mean stress p and constant intermediate stress ratio b.

use super::{INERTIAL_NUMBER, PathParameter, Preset, STATES, generous, number, stress};
use crate::loading::{Constraint, Control, Drive, Measure, RecordedStates, Stage, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "constant-p-and-b",
    help: "True triaxial test: axis x is strained at constant mean stress p and constant b = (sigma_y - sigma_z) / (sigma_x - sigma_z).",
    own: PARAMETERS,
    faults: |values| values.zero("axial_strain"),
    stages: |values| {
        let end = values.number("axial_strain");
        let b = values.number("b");
        let (free, fixed) = (Drive::Free, Drive::Fixed);
        let held = values.target("mean_stress");
        let proportional = Target::held(0.0);
        // With increasing b axis z expands faster: up to twice as fast as x is compressed.
        let axial = Drive::Rate(1.0 / (1.0 + b));
        let control = Control::new(values.speed(), [axial, free, free, fixed, fixed, fixed])
            .with(Constraint::mean_stress(held))
            .with(Constraint::stresses([-b, 1.0, b - 1.0, 0.0, 0.0, 0.0], proportional));
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let test = Stage {
            most_arc_length: generous(2.0 * end),
            resets: true,
            ..Stage::new("shear", control, vec![until]).recording(RecordedStates::equal(
                Measure::Strain(0),
                values.states(),
                end,
            ))
        };
        values.consolidation("mean_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("axial_strain", "Strain along x, the axis of the major stress, at the end.", 0.1, [1e-6, 3.0]),
    number(
        "b",
        "Intermediate stress ratio: 0 is triaxial compression, 1 triaxial extension.",
        0.5,
        [0.0, 1.0],
    ),
    stress("mean_stress", "Mean stress p, to which the sample is consolidated first and which is then held."),
    PathParameter {
        help: "Speed: inertial number I of 1 + b times the strain rate along x, at least the rate of the fastest axis.",
        ..INERTIAL_NUMBER
    },
    STATES,
];
