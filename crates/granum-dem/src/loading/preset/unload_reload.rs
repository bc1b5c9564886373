//! Drained triaxial compression with loops of unloading and reloading at given strains.

use super::{
    INERTIAL_NUMBER, PathParameter, PathParameterDefault, PathParameterKind, Preset, STATES, deviator,
    generous, number, stress,
};
use crate::loading::{Control, Drive, Measure, RecordedStates, Stage, Until};

pub(super) const PRESET: Preset = Preset {
    name: "unload-reload",
    help: "Drained triaxial compression along x in which the deviator stress is removed and reapplied at given strains.",
    own: PARAMETERS,
    faults: |_| None,
    stages: |values| {
        let end = values.number("axial_strain");
        let record = RecordedStates::every(Measure::ArcLength, end / values.number("states"));
        let stage = |name: String, sense: f64, until: Until| {
            let held = Drive::Stress(values.target("lateral_stress"));
            let fixed = Drive::Fixed;
            let control = Control::new(values.speed(), [Drive::Rate(sense), held, held, fixed, fixed, fixed]);
            let stage = Stage::new(name, control, vec![until]).recording(record.clone());
            Stage { most_arc_length: generous(end), ..stage }
        };
        let to = |strain: f64| Until::Reaches { measure: Measure::Strain(0), value: strain };
        let measure = Measure::AxialDeviatorStress;
        let off = Until::Reaches { measure, value: values.number("unloaded_deviator_stress") };
        let mut stages: Vec<Stage> = values.consolidation("lateral_stress").into_iter().collect();
        let mut name = "loading".to_string();
        let loops = values.list("at").iter().filter(|strain| **strain < end);
        for (k, strain) in loops.enumerate() {
            stages.push(stage(name, 1.0, to(*strain)));
            stages.push(stage(format!("unloading {}", k + 1), -1.0, off));
            name = format!("reloading {}", k + 1);
        }
        stages.push(stage(name, 1.0, to(end)));
        let first = usize::from(values.optional("lateral_stress").is_some());
        stages[first].resets = true;
        stages
    },
};

const PARAMETERS: &[PathParameter] = &[
    number("axial_strain", "Axial strain at the end.", 0.1, [1e-6, 3.0]),
    PathParameter {
        key: "at",
        kind: PathParameterKind::List,
        help: "Axial strains at which the sample is unloaded; those beyond axial_strain are ignored.",
        default: PathParameterDefault::List(&[0.01, 0.03, 0.06]),
        bounds: [1e-9, 3.0],
        ..STATES
    },
    deviator("unloaded_deviator_stress", "Deviator stress sigma_x - sigma_y at the end of an unloading."),
    stress(
        "lateral_stress",
        "Stress along y and z, to which the sample is first consolidated on all three axes.",
    ),
    INERTIAL_NUMBER,
    STATES,
];
