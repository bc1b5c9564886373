//! Isotropic compression or unloading to a mean stress.

use super::{INERTIAL_NUMBER, Parameter, Preset, STATES, consolidation, stress};
use crate::loading::{Measure, Record, Stage};

pub(super) const PRESET: Preset = Preset {
    name: "isotropic",
    help: "Isotropic compression or unloading: all three axes are brought to one stress, and the sample to rest there.",
    parameters: PARAMETERS,
    stages: |values| {
        // Without a stress of its own the sample comes to rest at 100 kPa.
        let stress = values.optional("mean_stress").unwrap_or(100e3);
        let stage = consolidation(stress, values.number("inertial_number"));
        let record = Record::every(Measure::ArcLength, values.number("interval"));
        vec![Stage { name: "isotropic".into(), resets: true, ..stage.recording(record) }]
    },
};

const PARAMETERS: &[Parameter] = &[
    Parameter {
        default: super::Default::Value(100e3),
        ..stress("mean_stress", "Stress that all three axes are brought to.")
    },
    INERTIAL_NUMBER,
    Parameter {
        key: "interval",
        help: "A state is recorded at every such arc length of strain.",
        default: super::Default::Value(1e-4),
        bounds: [1e-7, 1.0],
        ..STATES
    },
];
