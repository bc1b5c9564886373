//! Oedometer: axis x is compressed without lateral strain, then unloaded.

use super::{INERTIAL_NUMBER, INTERVAL, PathParameter, Preset, any_stress, stress};
use crate::loading::{Control, Drive, Measure, RecordedStates, Stage, Until};

pub(super) const PRESET: Preset = Preset {
    name: "oedometer",
    help: "Oedometer: axis x is compressed without lateral strain up to a stress, and unloaded if a second is given.",
    own: PARAMETERS,
    faults: |values| {
        let (loading, unloading) = (values.number("axial_stress"), values.optional("unloading_stress")?);
        (unloading >= loading).then(|| {
            let message = "unloading_stress must be below axial_stress, from which the sample is unloaded";
            ("unloading_stress", message.into())
        })
    },
    stages: |values| {
        let stage = |name: &str, sense: f64, stress: f64| {
            let fixed = Drive::Fixed;
            let drives = [Drive::Rate(sense), fixed, fixed, fixed, fixed, fixed];
            let until = Until::Reaches { measure: Measure::Stress(0), value: stress };
            Stage::new(name, Control::new(values.speed(), drives), vec![until])
                .recording(RecordedStates::every(Measure::ArcLength, values.number("interval")))
        };
        let loading = Stage { resets: true, ..stage("loading", 1.0, values.number("axial_stress")) };
        let unloading = values.optional("unloading_stress").map(|stress| stage("unloading", -1.0, stress));
        [loading].into_iter().chain(unloading).collect()
    },
};

const PARAMETERS: &[PathParameter] = &[
    PathParameter {
        default: super::PathParameterDefault::Value(1e6),
        ..stress("axial_stress", "Stress along x at the end of the loading.")
    },
    PathParameter {
        default: super::PathParameterDefault::Absent("no unloading"),
        ..any_stress("unloading_stress", "Stress along x at the end of the unloading.")
    },
    INERTIAL_NUMBER,
    PathParameter {
        help: "Arc length of strain between recorded states, which is sqrt(2/3) of the axial strain.",
        ..INTERVAL
    },
];
