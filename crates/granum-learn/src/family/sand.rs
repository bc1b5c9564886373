//! Sand: stiff grains without adhesion that resist rolling, along four paths.

use super::common_inputs::{
    COORDINATION_NUMBER, PREPARATION_RATIO, STRESS_OVER_MODULUS, VOID_RATIO, friction,
};
use super::common_outputs::{OUTPUTS, OUTPUTS_AT_CONSTANT_VOLUME, OUTPUTS_WITH_STRAIN};
use super::definition::{FamilyDefinition, FamilyInput, PATH};
use super::test_progress::TEST_PROGRESS;

/// The laws of the grains, and the path.
const fn words(path: &'static str) -> [(&'static str, &'static str); 4] {
    [
        ("contact.normal", "hertz"),
        ("contact.tangential", "no-slip"),
        ("contact.rolling", "elastic-plastic"),
        (PATH, path),
    ]
}

/// What is known of grains and sample.
const INPUTS: &[FamilyInput] = &[
    friction(0.8),
    FamilyInput {
        name: "rolling_friction",
        meaning: "coefficient of rolling friction of the grains",
        key: "contact.rolling_friction",
        over: &[],
        is_required: true,
        limits: Some([0.0, 0.5]),
    },
    STRESS_OVER_MODULUS,
    FamilyInput {
        name: "spread",
        meaning: "half the range of the diameters over their mean",
        key: "grains.spread",
        over: &[],
        is_required: false,
        limits: Some([0.0, 0.4]),
    },
    PREPARATION_RATIO,
    VOID_RATIO,
    COORDINATION_NUMBER,
];

/// Sand in drained triaxial compression.
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
    words: &words("drained-triaxial"),
    stress_keys: &[("stage.1.lateral_stress", 1.0)],
    coordinate: "axial_strain",
    inputs: INPUTS,
    outputs: OUTPUTS,
    plan: "sand-drained",
    about: &[
        ABOUT,
        SAMPLES,
        "They are then compressed axially at constant lateral stress, to an axial strain of 0.25 at an inertial number of 1e-3.",
    ],
    limits: &[
        "It knows one path, drained triaxial compression without unloading, from an isotropic sample.",
        MODEL,
        REAL,
        SCATTER,
        OUTSIDE,
    ],
};

/// The plan of the other paths of the sand.
const PATHS: &str = "sand-paths";

const ABOUT: &str = "Spheres with Hertz's normal law, a tangential law without slip below the limit of Coulomb, and elastic-plastic resistance to \
     rolling, without adhesion.";
const SAMPLES: &str = "Samples of 1000 grains in a periodic cell are compressed isotropically with a part of their friction, from none (dense) to \
     all of it (loose).";
const MODEL: &str = "At the highest stresses grains overlap by up to 9 % of a diameter: there the grains are those of the model, with contacts \
     that do not feel each other, and not those of an elastic solid.";
const REAL: &str = "Real sands are not spheres, and their coefficients of friction and rolling friction are not measured but calibrated.";
const SCATTER: &str = "A sample of 1000 grains scatters from seed to seed; the intervals are those of such a sample and not of a large one.";
const OUTSIDE: &str = "Outside the ranges of the inputs the answer is an extrapolation, and is flagged.";

/// Sand sheared at constant mean stress.
pub const SAND_CONSTANT_P: FamilyDefinition = FamilyDefinition {
    title: "sands sheared at constant mean stress",
    path: "constant-p",
    settings: &[
        ("grains.count", "1000"),
        ("preparation.cycles", "0"),
        ("path", "constant-p"),
        ("stage.1.deviator_strain", "0.35"),
        ("stage.1.states", "150"),
        ("recording.observations_per_state", "4"),
    ],
    stress_keys: &[],
    words: &words("constant-p"),
    coordinate: "deviator_strain",
    case: "undrained-dense",
    plan: PATHS,
    about: &[
        ABOUT,
        SAMPLES,
        "They are then compressed axially while the mean stress is held, to a deviator strain of 0.35 at an inertial number of 1e-3.",
    ],
    limits: &[
        "It knows axial compression at constant mean stress without unloading, from an isotropic sample.",
        MODEL,
        REAL,
        SCATTER,
        OUTSIDE,
    ],
    ..SAND
};

/// Sand in undrained triaxial compression.
pub const SAND_UNDRAINED: FamilyDefinition = FamilyDefinition {
    title: "sands in undrained triaxial compression",
    path: "undrained-triaxial",
    settings: &[
        ("grains.count", "1000"),
        ("preparation.cycles", "0"),
        ("path", "undrained-triaxial"),
        ("stage.1.axial_strain", "0.08"),
        ("stage.1.states", "150"),
        ("recording.observations_per_state", "4"),
    ],
    stress_keys: &[],
    words: &words("undrained-triaxial"),
    case: "undrained-dense",
    outputs: OUTPUTS_AT_CONSTANT_VOLUME,
    plan: PATHS,
    about: &[
        ABOUT,
        SAMPLES,
        "They are then compressed axially while the volume is held, to an axial strain of 0.08.",
    ],
    limits: &[
        "It knows undrained triaxial compression without unloading, from an isotropic sample.",
        "Samples that liquefy have a few contacts only, and scatter from one to the next by more than their curves differ.",
        MODEL,
        REAL,
        SCATTER,
        OUTSIDE,
    ],
    ..SAND
};

/// Sand in drained triaxial compression with a loop of unloading and reloading.
pub const SAND_UNLOAD_RELOAD: FamilyDefinition = FamilyDefinition {
    title: "sands in drained triaxial compression with loops of unloading",
    path: "unload-reload",
    settings: &[
        ("grains.count", "1000"),
        ("preparation.cycles", "0"),
        ("path", "unload-reload"),
        ("stage.1.axial_strain", "0.08"),
        ("stage.1.states", "150"),
        ("recording.observations_per_state", "4"),
    ],
    stress_keys: &[],
    words: &words("unload-reload"),
    coordinate: TEST_PROGRESS,
    outputs: OUTPUTS_WITH_STRAIN,
    case: "undrained-dense",
    plan: PATHS,
    about: &[
        ABOUT,
        SAMPLES,
        "They are then compressed axially at constant lateral stress, to an axial strain of 0.08; at 0.01, 0.03 and 0.06 they are unloaded to \
         the isotropic stress and loaded again.",
        "The coordinate, the progress of the test, counts the stages (loading, unloading, loading and so on); within a stage it is the root of the \
         share of its strain, since how far an unloading strains the sample depends on the sample. The axial strain is an output.",
    ],
    limits: &[
        "It knows the loops of its path alone, from an isotropic sample.",
        MODEL,
        REAL,
        SCATTER,
        OUTSIDE,
    ],
    ..SAND
};
