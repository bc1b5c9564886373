//! Proportional loading: the strains of the three axes, or their stresses, keep constant ratios.

use super::{
    INERTIAL_NUMBER, PathParameter, PathValues, Preset, STATES, generous, number, optional, stress, word,
};
use crate::loading::{Constraint, Control, Drive, Measure, Ramp, RecordedStates, Stage, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "proportional",
    help: "Proportional loading: the strains along y and z are constant multiples of that along x; or the stresses \
           are, which are first brought to these ratios at constant mean stress.",
    own: PARAMETERS,
    faults: |values| values.zero("axial_strain"),
    stages: |values| {
        let end = values.number("axial_strain");
        let by_stress = values.is("ratios_of", "stress");
        let control = if by_stress { stresses(values, end.signum()) } else { strains(values, end.signum()) };
        let mut until = vec![Until::Reaches { measure: Measure::Strain(0), value: end }];
        let stress = values.optional("axial_stress");
        until.extend(stress.map(|value| Until::Reaches { measure: Measure::Stress(0), value }));
        let record = RecordedStates::every(Measure::ArcLength, end.abs() / values.number("states"));
        let most = generous(end * (1.0 + ratio(values, 1).abs() + ratio(values, 2).abs()));
        let test = Stage {
            most_arc_length: most,
            resets: true,
            ..Stage::new("proportional", control, vec![]).recording(record)
        };
        let approach = by_stress.then(|| approach(values));
        let consolidation = values.consolidation("mean_stress");
        consolidation.into_iter().chain(approach).chain([Stage { until, ..test }]).collect()
    },
};

/// Ratio of axis y (1) or z (2) to axis x.
fn ratio(values: &PathValues, axis: usize) -> f64 {
    values.number(["", "ratio_y", "ratio_z"][axis])
}

fn strains(values: &PathValues, sense: f64) -> Control {
    let fixed = Drive::Fixed;
    let rates = [1.0, ratio(values, 1), ratio(values, 2)].map(|rate| Drive::Rate(sense * rate));
    Control::new(values.speed(), [rates[0], rates[1], rates[2], fixed, fixed, fixed])
}

/// The constraint that `sigma_axis - ratio sigma_x` follows its target.
fn in_ratio(values: &PathValues, axis: usize, target: Target) -> Constraint {
    let mut weights = [0.0; 6];
    weights[0] = -ratio(values, axis);
    weights[axis] = 1.0;
    Constraint::stresses(weights, target)
}

fn stresses(values: &PathValues, sense: f64) -> Control {
    let (free, fixed) = (Drive::Free, Drive::Fixed);
    Control::new(values.speed(), [Drive::Rate(sense), free, free, fixed, fixed, fixed])
        .with(in_ratio(values, 1, Target::held(0.0)))
        .with(in_ratio(values, 2, Target::held(0.0)))
}

/// The stage that brings the stresses to their ratios at constant mean stress.
fn approach(values: &PathValues) -> Stage {
    let (free, fixed) = (Drive::Free, Drive::Fixed);
    let control = Control::new(values.speed(), [free, free, free, fixed, fixed, fixed])
        .with(Constraint::mean_stress(values.target("mean_stress")))
        .with(in_ratio(values, 1, Target::ramp(Ramp::To(0.0))))
        .with(in_ratio(values, 2, Target::ramp(Ramp::To(0.0))));
    Stage { most_arc_length: Some(0.3), ..Stage::new("to the ratios", control, vec![Until::RampOver]) }
}

const PARAMETERS: &[PathParameter] = &[
    word(
        "ratios_of",
        "What has constant ratios.",
        &[["strain", "strain increments"], ["stress", "stresses"]],
    ),
    number("ratio_y", "Strain or stress along y over that along x.", 0.6, [-3.0, 3.0]),
    number("ratio_z", "Strain or stress along z over that along x.", 0.6, [-3.0, 3.0]),
    number("axial_strain", "Strain along x at the end; negative for unloading.", 0.01, [-3.0, 3.0]),
    PathParameter {
        unit: "Pa",
        ..optional(
            "axial_stress",
            "Stress along x at which the path ends, if it is reached before axial_strain.",
            "the path ends at axial_strain",
            [1e-3, 1e11],
        )
    },
    stress("mean_stress", "Mean stress to which the sample is consolidated first."),
    INERTIAL_NUMBER,
    STATES,
];
