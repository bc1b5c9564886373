//! Hold: the stresses are constant and the sample creeps, or the strains are constant and the stresses relax.

use super::{INERTIAL_NUMBER, INTERVAL, PathParameter, Preset, number, optional, word};
use crate::loading::{Control, Drive, Measure, RecordedStates, Stage, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "hold",
    help: "All stresses are held (creep), or all strains (relaxation), until the sample is at rest or for a given \
           time.",
    own: PARAMETERS,
    faults: |values| {
        let rest = values.both("unbalanced_force", "duration");
        rest.or_else(|| values.both("interval", "duration"))
    },
    stages: |values| {
        let held = match values.is("held", "stress") {
            true => Drive::Stress(Target::current()),
            false => Drive::Fixed,
        };
        let rest = Until::AtRest { unbalanced_force: values.number("unbalanced_force") };
        let time = values.optional("duration");
        let until = time.map_or(rest, |value| Until::Reaches { measure: Measure::Time, value });
        let record = match time {
            Some(time) => RecordedStates::every(Measure::Time, time / values.number("states")),
            None => RecordedStates::every(Measure::ArcLength, values.number("interval")),
        };
        let control = Control::new(values.speed(), [held; 6]);
        let stage = Stage::new("hold", control, vec![until]).recording(record);
        vec![Stage { most_arc_length: Some(0.1), resets: true, ..stage }, Stage::mark("held")]
    },
};

const PARAMETERS: &[PathParameter] = &[
    word(
        "held",
        "What is held constant.",
        &[["stress", "all six stresses; any strain is creep"], ["strain", "all strains; the stresses relax"]],
    ),
    PathParameter {
        unit: "s",
        ..optional(
            "duration",
            "Simulated time for which they are held.",
            "until the sample is at rest",
            [1e-15, 1e9],
        )
    },
    number(
        "unbalanced_force",
        "Unbalanced force over the mean contact force below which the sample is at rest.",
        1e-3,
        [1e-9, 1.0],
    ),
    INERTIAL_NUMBER,
    INTERVAL,
    PathParameter {
        default: super::PathParameterDefault::Value(20.0),
        help: "Number of equal intervals of the duration; a state is recorded at the end of each.",
        ..super::STATES
    },
];
