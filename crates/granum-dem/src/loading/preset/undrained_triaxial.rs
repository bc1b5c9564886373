//! Undrained triaxial test: the volume of a saturated sample stays, and so the two lateral strains are half the axial one.

use super::{INERTIAL_NUMBER, Parameter, Preset, STATES, generous, number, stress};
use crate::loading::{Control, Drive, Measure, Record, Stage, Until};

pub(super) const PRESET: Preset = Preset {
    name: "undrained-triaxial",
    help: "Undrained triaxial compression or extension: axis x is strained at constant volume. The stresses are effective ones.",
    parameters: PARAMETERS,
    stages: |values| {
        let end = values.number("axial_strain");
        let (axial, fixed) = (Drive::Rate(end.signum()), Drive::Fixed);
        let lateral = Drive::Rate(-0.5 * end.signum());
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let control = Control::of(values.speed(), [axial, lateral, lateral, fixed, fixed, fixed]);
        let test = Stage {
            most_arc_length: generous(end),
            resets: true,
            ..Stage::new("shear", control, vec![until]).recording(Record::equal(
                Measure::ArcLength,
                values.states(),
                end.abs(),
            ))
        };
        values.consolidation("mean_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[Parameter] = &[
    number("axial_strain", "Axial strain at the end; negative for extension.", 0.2, [-3.0, 3.0]),
    stress("mean_stress", "Mean effective stress to which the sample is brought before."),
    INERTIAL_NUMBER,
    STATES,
];
