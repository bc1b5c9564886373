//! Powder: fine grains that stick to each other and rub, in compression.

use super::common_inputs::{COORDINATION_NUMBER, PREPARATION_RATIO, VOID_RATIO, friction};
use super::common_outputs::{OUTPUTS, OUTPUTS_TO_A_STRESS};
use super::definition::{FamilyDefinition, FamilyInput, PATH};
use super::test_progress::TEST_PROGRESS;

/// The laws of the grains, and the path.
const fn words(path: &'static str) -> [(&'static str, &'static str); 3] {
    [("contact.normal", "jkr"), ("contact.tangential", "mindlin-deresiewicz"), (PATH, path)]
}

/// What is known of grains and sample.
const INPUTS: &[FamilyInput] = &[
    friction(0.6),
    FamilyInput {
        name: "adhesion_number",
        meaning: "interface energy over the stress of the sample and the mean diameter",
        key: "grains.material.interface_energy",
        over: &["preparation.mean_stress", "grains.diameter"],
        is_required: true,
        limits: Some([0.01, 10.0]),
    },
    FamilyInput {
        name: "stress_over_modulus",
        meaning: "stress of the sample over Young's modulus of the grains",
        key: "preparation.mean_stress",
        over: &["grains.material.youngs_modulus"],
        is_required: true,
        limits: Some([1e-5, 1e-4]),
    },
    PREPARATION_RATIO,
    VOID_RATIO,
    COORDINATION_NUMBER,
];

const ABOUT: &str = "Spheres with JKR adhesion and the tangential law of Mindlin and Deresiewicz, without resistance to rolling, with a \
     lognormal distribution of diameters about 10 um.";
const SAMPLES: &str = "Samples of 500 grains in a periodic cell are compressed isotropically to 5 kPa with a part of their friction, from none \
     (dense) to all of it (loose).";
const SCATTER: &str = "A sample of 500 grains scatters from seed to seed; the intervals are those of such a sample and not of a large one.";
const OUTSIDE: &str = "Outside the ranges of the inputs the answer is an extrapolation, and is flagged.";

/// Powder sheared at constant mean stress.
pub const POWDER_CONSTANT_P: FamilyDefinition = FamilyDefinition {
    name: "powder",
    title: "cohesive powders sheared at constant mean stress",
    path: "constant-p",
    case: "powder-oedometer",
    settings: &[
        ("grains.count", "500"),
        ("preparation.mean_stress", "5 kPa"),
        ("preparation.inertial_number", "5e-3"),
        ("contact.tangential", "mindlin-deresiewicz"),
        ("contact.rolling_friction", "0"),
        ("recording.observations_per_state", "4"),
        ("path", "constant-p"),
        ("stage.1.deviator_strain", "0.3"),
        ("stage.1.states", "150"),
    ],
    stress_keys: &[],
    words: &words("constant-p"),
    coordinate: "deviator_strain",
    inputs: INPUTS,
    outputs: OUTPUTS,
    plan: "powder-paths",
    about: &[
        ABOUT,
        SAMPLES,
        "They are compressed axially while the mean stress is held, to a deviator strain of 0.3.",
    ],
    limits: &[
        "It knows axial compression at constant mean stress, from an isotropic sample.",
        SCATTER,
        OUTSIDE,
    ],
};

/// Powder in the oedometer.
pub const POWDER_OEDOMETER: FamilyDefinition = FamilyDefinition {
    title: "cohesive powders in the oedometer",
    path: "oedometer",
    stress_keys: &[("stage.1.axial_stress", 20.0)],
    settings: &[
        ("grains.count", "500"),
        ("preparation.mean_stress", "5 kPa"),
        ("preparation.inertial_number", "5e-3"),
        ("contact.tangential", "mindlin-deresiewicz"),
        ("contact.rolling_friction", "0"),
        ("recording.observations_per_state", "4"),
        ("path", "oedometer"),
        ("stage.1.axial_stress", "100 kPa"),
        ("stage.1.inertial_number", "2e-3"),
        ("stage.1.interval", "1e-3"),
    ],
    words: &words("oedometer"),
    coordinate: TEST_PROGRESS,
    outputs: OUTPUTS_TO_A_STRESS,
    about: &[
        ABOUT,
        SAMPLES,
        "They are compressed axially without lateral strain, to an axial stress of 100 kPa, twenty times that of the sample.",
        "The coordinate, the progress of the test, is the root of the share of its strain, since the strain at which the stress is reached depends on \
         the sample. Strain and mean stress are outputs.",
    ],
    limits: &[
        "It knows loading in the oedometer without unloading, from an isotropic sample.",
        SCATTER,
        OUTSIDE,
    ],
    ..POWDER_CONSTANT_P
};
