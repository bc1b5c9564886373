//! Simple shear at constant volume: grains move along x in proportion to y, and no axis is strained.

use super::simple_shear::shear;
use super::{INERTIAL_NUMBER, PathParameter, Preset, STATES, number, stress};
use crate::loading::Drive;

pub(super) const PRESET: Preset = Preset {
    name: "simple-shear-constant-volume",
    help: "Simple shear in the plane xy at constant volume: an undrained simple shear test.",
    own: PARAMETERS,
    faults: |values| values.zero("shear_strain"),
    stages: |values| {
        let test = shear(values.speed(), Drive::Fixed, values.number("shear_strain"), values.states());
        values.consolidation("mean_stress").into_iter().chain([test]).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("shear_strain", "Shear strain gamma_xy at the end.", 0.3, [1e-6, 1.0]),
    stress("mean_stress", "Mean stress to which the sample is consolidated first."),
    INERTIAL_NUMBER,
    STATES,
];
