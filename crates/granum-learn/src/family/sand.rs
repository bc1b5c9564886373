//! Sand: stiff grains without adhesion that resist rolling, in drained triaxial compression.

use super::definition::{FamilyDefinition, FamilyInput, FamilyOutput};

/// The family sand.
pub const SAND: FamilyDefinition = FamilyDefinition {
    name: "sand",
    title: "sands in drained triaxial compression",
    path: "drained-triaxial",
    case: "drained-dense",
    settings: &[
        ("grains.count", "1000"),
        ("preparation.cycles", "0"),
        ("stage.1.axial_strain", "0.25"),
        ("stage.1.states", "250"),
        ("recording.observations_per_state", "4"),
    ],
    words: &[
        ("contact.normal", "hertz"),
        ("contact.tangential", "no-slip"),
        ("contact.rolling", "elastic-plastic"),
        ("stage.1.path", "drained-triaxial"),
    ],
    coordinate: "axial_strain",
    inputs: &[
        FamilyInput {
            name: "friction",
            meaning: "coefficient of friction of the grains",
            key: "grains.material.friction",
            over: &[],
            is_required: true,
        },
        FamilyInput {
            name: "rolling_friction",
            meaning: "coefficient of rolling friction of the grains",
            key: "contact.rolling_friction",
            over: &[],
            is_required: true,
        },
        FamilyInput {
            name: "stress_over_modulus",
            meaning: "confining stress over Young's modulus of the grains",
            key: "preparation.mean_stress",
            over: &["grains.material.youngs_modulus"],
            is_required: true,
        },
        FamilyInput {
            name: "spread",
            meaning: "half the range of the diameters over their mean",
            key: "grains.spread",
            over: &[],
            is_required: false,
        },
        FamilyInput {
            name: "preparation_ratio",
            meaning: "friction while the sample is made over that of the grains (0 dense, 1 loose)",
            key: "preparation.friction",
            over: &["grains.material.friction"],
            is_required: false,
        },
        FamilyInput {
            name: "sample.void_ratio",
            meaning: "void ratio of the sample",
            key: "sample.void_ratio",
            over: &[],
            is_required: false,
        },
        FamilyInput {
            name: "sample.mechanical_coordination_number",
            meaning: "mechanical coordination number of the sample",
            key: "sample.mechanical_coordination_number",
            over: &[],
            is_required: false,
        },
    ],
    outputs: &[
        FamilyOutput { column: "stress_ratio", meaning: "deviator stress over mean stress", symbol: "q/p" },
        FamilyOutput { column: "volumetric_strain", meaning: "volumetric strain", symbol: "e_v" },
        FamilyOutput { column: "deviator_fabric", meaning: "deviator fabric", symbol: "phi_d" },
        FamilyOutput {
            column: "mechanical_coordination_number",
            meaning: "mechanical coordination number",
            symbol: "Z_m",
        },
        FamilyOutput { column: "sliding_fraction", meaning: "share of the contacts that slide", symbol: "" },
        FamilyOutput {
            column: "probability_density",
            meaning: "distribution of the normal contact forces over their mean",
            symbol: "P(f)",
        },
    ],
    plan: "sand-drained",
    about: &[
        "Spheres with Hertz's normal law, a tangential law without slip below the limit of Coulomb, and elastic-plastic resistance to \
         rolling, without adhesion.",
        "Samples of 1000 grains in a periodic cell are compressed isotropically with a part of their friction, from none (dense) to all \
         of it (loose), and then axially at constant lateral stress, to an axial strain of 0.25 at an inertial number of 1e-3.",
    ],
    limits: &[
        "It knows one path, drained triaxial compression without unloading, from an isotropic sample.",
        "At the highest stresses grains overlap by up to 9 % of a diameter: there the grains are those of the model, with contacts that do \
         not feel each other, and not those of an elastic solid.",
        "Real sands are not spheres, and their coefficients of friction and rolling friction are not measured but calibrated.",
        "A sample of 1000 grains scatters from seed to seed; the intervals are those of such a sample and not of a large one.",
        "Outside the ranges of the inputs the answer is an extrapolation, and is flagged.",
    ],
};
