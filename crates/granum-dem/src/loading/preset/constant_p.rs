//! Axisymmetric compression at constant mean stress, the test of Antony, Zhou and Wang (2006): axis x is strained at a
//! constant rate, axes y and z move together so that p = (sigma_1 + sigma_2 + sigma_3)/3 stays at its target.

use super::definition::generous;
use super::{INERTIAL_NUMBER, PathParameter, Preset, STATES, number, stress};
use crate::config::{Rate, Recording, Shear};
use crate::loading::{
    Constraint, Control, Drive, Measure, RecordedStates, Speed, Stage, Target, Until, density_scaling,
};
use crate::servo::RESPONSE;

pub(super) const PRESET: Preset = Preset {
    name: "constant-p",
    help: "Axisymmetric compression or extension at constant mean stress: the test of Antony, Zhou and Wang (2006).",
    own: PARAMETERS,
    faults: |values| values.zero("deviator_strain"),
    stages: |values| {
        let end = values.number("deviator_strain");
        let test = Stage {
            most_arc_length: generous(end),
            resets: true,
            ..stage(
                values.speed(),
                end.signum(),
                None,
                Until::Reaches { measure: Measure::AxialDeviatorStrain, value: end },
            )
        };
        let record = RecordedStates::equal(Measure::DeviatoricStrain, values.states(), 2.0 / 3.0 * end.abs());
        values.consolidation("mean_stress").into_iter().chain([test.recording(record)]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number(
        "deviator_strain",
        "Deviator strain eps_1 - eps_3 at the end; negative for extension along x.",
        0.3,
        [-3.0, 3.0],
    ),
    stress("mean_stress", "Mean stress p, to which the sample is consolidated first and which is then held."),
    INERTIAL_NUMBER,
    STATES,
];

fn stage(speed: Speed, sense: f64, mean_stress: Option<f64>, until: Until) -> Stage {
    let lateral = Drive::Rate(-0.5 * sense);
    let fixed = Drive::Fixed;
    let control = Control::new(speed, [Drive::Rate(sense), lateral, lateral, fixed, fixed, fixed]).with(
        Constraint::mean_stress(mean_stress.map_or_else(Target::current, Target::held))
            .moving([0.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
    );
    Stage::new("shear", control, vec![until])
}

/// The test of the paper as defined by the section `[shear]` of a case, on a sample prepared at `sample_stress`, Pa.
pub fn antony2006(shear: &Shear, recording: &Recording, sample_stress: f64) -> Stage {
    let mean_stress = shear.mean_stress.unwrap_or(sample_stress);
    let speed = match shear.rate {
        Rate::InertialNumber(number) => Speed::InertialNumber { number, at: Some(mean_stress) },
        Rate::StrainRate { strain_rate, .. } => Speed::StrainRate(strain_rate),
    };
    let end = shear.deviator_strain;
    let until = Until::Reaches { measure: Measure::AxialDeviatorStrain, value: end };
    let record = RecordedStates {
        measure: Measure::AxialDeviatorStrain,
        states: recording.states,
        spacing: recording.spacing.clone(),
        end,
    };
    let mut stage = stage(speed, 1.0, Some(mean_stress), until);
    stage.control.response = RESPONSE;
    stage.control.eases = false;
    let density_scaling = density_scaling(&shear.rate);
    Stage { resets: true, most_arc_length: None, density_scaling, ..stage }.recording(record)
}
