//! What is predicted of tests of all families.

use super::definition::FamilyOutput;

/// An output that is a column of a run.
const fn output(column: &'static str, meaning: &'static str, symbol: &'static str) -> FamilyOutput {
    FamilyOutput { column, ratio: None, meaning, symbol }
}

const AXIAL_STRAIN: FamilyOutput = output("axial_strain", "axial strain", "e_1");
const STRESS_RATIO: FamilyOutput = output("stress_ratio", "deviator stress over mean stress", "q/p");
const MEAN_STRESS: FamilyOutput = FamilyOutput {
    column: "mean_stress_over_initial",
    ratio: Some(("mean_stress", "preparation.mean_stress")),
    meaning: "mean stress over that of the sample",
    symbol: "p/p_0",
};
const VOLUME: FamilyOutput = output("volumetric_strain", "volumetric strain", "e_v");
const FABRIC: FamilyOutput = output("deviator_fabric", "deviator fabric", "phi_d");
const COORDINATION: FamilyOutput =
    output("mechanical_coordination_number", "mechanical coordination number", "Z_m");
const SLIDING: FamilyOutput = output("sliding_fraction", "share of the contacts that slide", "");
const FORCES: FamilyOutput =
    output("probability_density", "distribution of the normal contact forces over their mean", "P(f)");

/// Where the volume changes.
pub(super) const OUTPUTS: &[FamilyOutput] = &[STRESS_RATIO, VOLUME, FABRIC, COORDINATION, SLIDING, FORCES];

/// Where the volume is held.
pub(super) const OUTPUTS_AT_CONSTANT_VOLUME: &[FamilyOutput] =
    &[STRESS_RATIO, MEAN_STRESS, FABRIC, COORDINATION, SLIDING, FORCES];

/// Where the axial strain turns, so that it is no coordinate.
pub(super) const OUTPUTS_WITH_STRAIN: &[FamilyOutput] =
    &[AXIAL_STRAIN, STRESS_RATIO, VOLUME, FABRIC, COORDINATION, SLIDING, FORCES];

/// Where a test ends at a stress, and there is no lateral strain, so that the axial strain is that of the volume.
pub(super) const OUTPUTS_TO_A_STRESS: &[FamilyOutput] =
    &[AXIAL_STRAIN, STRESS_RATIO, MEAN_STRESS, FABRIC, COORDINATION, SLIDING, FORCES];
