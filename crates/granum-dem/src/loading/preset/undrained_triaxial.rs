//! Undrained triaxial test: the volume of a saturated sample is constant, so that each lateral strain is minus half the
//! axial one.

use super::{INERTIAL_NUMBER, PathParameter, PathParameterDefault, Preset, STATES, generous, number, stress};
use crate::loading::{Constraint, Control, Drive, Measure, RecordedStates, Stage, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "undrained-triaxial",
    help: "Undrained triaxial compression or extension: axis x is strained at constant volume. The stresses are effective ones.",
    own: PARAMETERS,
    faults: |values| values.zero("axial_strain"),
    stages: |values| {
        let end = values.number("axial_strain");
        let (axial, free, fixed) = (Drive::Rate(end.signum()), Drive::Free, Drive::Fixed);
        let lateral = Drive::Rate(-0.5 * end.signum());
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let control = match values.optional("fluid_modulus") {
            None => Control::new(values.speed(), [axial, lateral, lateral, fixed, fixed, fixed]),
            // The sum of the pore pressure K_f eps_v / n and of the effective stress along z is the constant cell pressure.
            Some(modulus) => Control::new(values.speed(), [axial, free, free, fixed, fixed, fixed])
                .with(Constraint::strains([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], 0.0))
                .with(Constraint {
                    strain: [modulus, modulus, modulus, 0.0, 0.0, 0.0],
                    ..Constraint::stresses([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], Target::current())
                }),
        };
        // With a compressible fluid the arc length is not the axial strain, so that the end is not known.
        let record = match values.optional("fluid_modulus") {
            None => RecordedStates::equal(Measure::ArcLength, values.states(), end.abs()),
            Some(_) => RecordedStates::every(Measure::ArcLength, end.abs() / values.number("states")),
        };
        let test = Stage {
            most_arc_length: generous(end),
            resets: true,
            ..Stage::new("shear", control, vec![until]).recording(record)
        };
        values.consolidation("mean_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("axial_strain", "Axial strain at the end; negative for extension.", 0.2, [-3.0, 3.0]),
    stress("mean_stress", "Mean effective stress to which the sample is consolidated first."),
    INERTIAL_NUMBER,
    STATES,
    PathParameter {
        default: PathParameterDefault::Absent(
            "the fluid is incompressible, and the volume of the sample is constant",
        ),
        ..stress("fluid_modulus", "Bulk modulus of the pore fluid over the porosity, K_f / n.")
    },
];
