//! Hold: the stresses stay as they are and strains creep, or the strains stay and stresses relax.

use super::{INERTIAL_NUMBER, INTERVAL, Parameter, Preset, number, optional, word};
use crate::loading::{Control, Drive, Measure, Record, Stage, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "hold",
    help: "All stresses are held (creep), or all strains (relaxation), until the sample is at rest or for a time.",
    own: PARAMETERS,
    stages: |values| {
        let held = match values.is("held", "stress") {
            true => Drive::Stress(Target::current()),
            false => Drive::Fixed,
        };
        let rest = Until::AtRest { unbalanced_force: values.number("unbalanced_force") };
        let time = values.optional("duration");
        let until = time.map_or(rest, |value| Until::Reaches { measure: Measure::Time, value });
        let record = match time {
            Some(time) => Record::every(Measure::Time, time / values.number("states")),
            None => Record::every(Measure::ArcLength, values.number("interval")),
        };
        let control = Control::of(values.speed(), [held; 6]);
        let stage = Stage::new("hold", control, vec![until]).recording(record);
        vec![Stage { most_arc_length: Some(0.1), resets: true, ..stage }, Stage::mark("held")]
    },
};

const PARAMETERS: &[Parameter] = &[
    word(
        "held",
        "What stays as it is.",
        &[["stress", "all six stresses: what strains is creep"], ["strain", "all strains: stresses relax"]],
    ),
    Parameter {
        unit: "s",
        ..optional("duration", "Simulated time that it takes.", "until the sample is at rest", [1e-15, 1e9])
    },
    number(
        "unbalanced_force",
        "Unbalanced force over the mean contact force below which the sample is at rest.",
        1e-3,
        [1e-9, 1.0],
    ),
    INERTIAL_NUMBER,
    INTERVAL,
    Parameter {
        default: super::Default::Value(20.0),
        help: "Number of equal intervals of a duration at whose ends a state is recorded.",
        ..super::STATES
    },
];
