//! Sand of long grains: capsules of three spheres without adhesion and without resistance to rolling.

use super::common_inputs::{
    COORDINATION_NUMBER, PREPARATION_RATIO, STRESS_OVER_MODULUS, VOID_RATIO, friction,
};
use super::common_outputs::OUTPUTS;
use super::definition::{FamilyDefinition, FamilyInput, PATH};

/// What is known of grains and sample.
const INPUTS: &[FamilyInput] = &[
    FamilyInput {
        name: "aspect_ratio",
        meaning: "length of the grains over their thickness",
        key: "grains.shape.aspect_ratio",
        over: &[],
        is_required: true,
        limits: Some([1.05, 2.5]),
    },
    friction(0.8),
    STRESS_OVER_MODULUS,
    PREPARATION_RATIO,
    VOID_RATIO,
    COORDINATION_NUMBER,
];

/// Sand of long grains in drained triaxial compression.
pub const SHAPED_SAND: FamilyDefinition = FamilyDefinition {
    name: "shaped-sand",
    title: "sands of long grains in drained triaxial compression",
    path: "drained-triaxial",
    case: "long-grains",
    settings: &[
        ("grains.count", "1000"),
        ("grains.shape.pieces", "3"),
        ("stage.1.axial_strain", "0.25"),
        ("stage.1.states", "250"),
        ("recording.observations_per_state", "4"),
    ],
    words: &[
        ("grains.shape.kind", "capsule"),
        ("contact.normal", "hertz"),
        ("contact.tangential", "no-slip"),
        ("contact.rolling", "none"),
        (PATH, "drained-triaxial"),
    ],
    stress_keys: &[("stage.1.lateral_stress", 1.0)],
    coordinate: "axial_strain",
    inputs: INPUTS,
    outputs: OUTPUTS,
    plan: "shaped-sand",
    about: &[
        "Capsules, rigid grains of three equal spheres in a row, with Hertz's normal law and a tangential law without slip below the limit of \
         Coulomb, without adhesion and without resistance to rolling. Diameters are those of spheres of equal volume, and vary by a fifth about \
         their mean.",
        "Samples of 1000 grains in a periodic cell are compressed isotropically from random directions with a part of their friction, from none \
         (dense) to all of it (loose).",
        "They are then compressed axially at constant lateral stress, to an axial strain of 0.25 at an inertial number of 1e-3.",
    ],
    limits: &[
        "It knows one path, drained triaxial compression without unloading, from an isotropic sample whose grains lie in all directions.",
        "It knows one family of shapes. The waists between the spheres of a capsule act as roughness, and more spheres in a row pack more \
         densely.",
        "Coordination numbers and distributions of forces are those of contacts; two grains can touch in several.",
        "At the highest stresses grains overlap by several per cent of a diameter: there the grains are those of the model, with contacts that do \
         not feel each other, and not those of an elastic solid.",
        "A sample of 1000 grains scatters from seed to seed; the intervals are those of such a sample and not of a large one.",
        "Outside the ranges of the inputs the answer is an extrapolation, and is flagged.",
    ],
};
