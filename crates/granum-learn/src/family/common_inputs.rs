//! Inputs that all families have: what is known of any grains and samples.

use super::definition::FamilyInput;

/// The friction of the grains, from a tenth to a value that the family has.
pub(super) const fn friction(most: f64) -> FamilyInput {
    FamilyInput {
        name: "friction",
        meaning: "coefficient of friction of the grains",
        key: "grains.material.friction",
        over: &[],
        is_required: true,
        limits: Some([0.1, most]),
    }
}

/// The stress over the modulus of the grains: how much they overlap.
pub(super) const STRESS_OVER_MODULUS: FamilyInput = FamilyInput {
    name: "stress_over_modulus",
    meaning: "confining stress over Young's modulus of the grains",
    key: "preparation.mean_stress",
    over: &["grains.material.youngs_modulus"],
    is_required: true,
    limits: Some([1e-5, 4e-4]),
};

/// How loosely a sample was made.
pub(super) const PREPARATION_RATIO: FamilyInput = FamilyInput {
    name: "preparation_ratio",
    meaning: "friction while the sample is made over that of the grains (0 dense, 1 loose)",
    key: "preparation.friction",
    over: &["grains.material.friction"],
    is_required: false,
    limits: Some([0.0, 1.0]),
};

/// The void ratio of a sample.
pub(super) const VOID_RATIO: FamilyInput = FamilyInput {
    name: "sample.void_ratio",
    meaning: "void ratio of the sample",
    key: "sample.void_ratio",
    over: &[],
    is_required: false,
    limits: None,
};

/// The mechanical coordination number of a sample.
pub(super) const COORDINATION_NUMBER: FamilyInput = FamilyInput {
    name: "sample.mechanical_coordination_number",
    meaning: "mechanical coordination number of the sample",
    key: "sample.mechanical_coordination_number",
    over: &[],
    is_required: false,
    limits: None,
};
