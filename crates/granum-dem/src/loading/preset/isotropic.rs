//! Isotropic compression or unloading to a mean stress, and back to another one.

use super::{INERTIAL_NUMBER, INTERVAL, PathParameter, Preset, any_stress, consolidation};
use crate::loading::{Measure, RecordedStates, Speed, Stage};

pub(super) const PRESET: Preset = Preset {
    name: "isotropic",
    help: "Isotropic compression or unloading: all three axes are brought to one stress, at which the sample comes to \
           rest; then to a second stress if one is given.",
    own: PARAMETERS,
    faults: |_| None,
    stages: |values| {
        let stage = |name: &str, stress: f64| {
            let record = RecordedStates::every(Measure::ArcLength, values.number("interval"));
            let mut stage = consolidation(stress, values.number("inertial_number")).recording(record);
            if let Speed::StrainRate(_) = values.speed() {
                stage.control.speed = values.speed();
            }
            Stage { name: name.into(), ..stage }
        };
        let first = Stage { resets: true, ..stage("isotropic", values.number("mean_stress")) };
        let second = values.optional("unloading_stress").map(|stress| stage("unloading", stress));
        [first].into_iter().chain(second).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    PathParameter {
        default: super::PathParameterDefault::Value(100e3),
        ..any_stress("mean_stress", "Stress to which all three axes are brought; negative for tension.")
    },
    INERTIAL_NUMBER,
    INTERVAL,
    PathParameter {
        default: super::PathParameterDefault::Absent("no unloading"),
        ..any_stress("unloading_stress", "Stress to which all three axes are brought afterwards.")
    },
];
