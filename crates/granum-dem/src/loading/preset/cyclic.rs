//! Cyclic triaxial test: the strain along x is reversed at two strains or two deviator stresses, drained or undrained.

use super::{
    INERTIAL_NUMBER, PathParameter, PathParameterDefault, PathValues, Preset, deviator, number, optional,
    stress, word,
};
use crate::loading::{
    Constraint, Control, Drive, Measure, Ramp, RecordedStates, Stage, Target, Turns, Until,
};

pub(super) const PRESET: Preset = Preset {
    name: "cyclic",
    help: "Cyclic triaxial test between two axial strains or two deviator stresses, drained or undrained: a number of \
           cycles, or until liquefaction or a double amplitude of strain.",
    own: PARAMETERS,
    faults: |values| {
        let amplitudes = values.both("strain_amplitude", "stress_amplitude");
        amplitudes.or_else(|| values.both("mean_strain", "stress_amplitude")).or_else(|| {
            (values.is_given("pore_pressure_ratio") && !undrained(values)).then(|| {
                let message = "pore_pressure_ratio has no effect with drainage = \"drained\"; leave it out, or choose \"undrained\"";
                ("pore_pressure_ratio", message.into())
            })
        })
    },
    stages: |values| {
        let cycles = values.number("cycles");
        let by_stress = values.optional("stress_amplitude");
        let amplitude = values.number("strain_amplitude");
        let (measure, middle, amplitude) = match by_stress {
            Some(stress) => (Measure::AxialDeviatorStress, values.number("mean_deviator_stress"), stress),
            None => (Measure::Strain(0), values.number("mean_strain"), amplitude),
        };
        let mut until = vec![Until::Reversals(2 * cycles as u64)];
        if undrained(values) {
            until.push(Until::PorePressureRatio(values.number("pore_pressure_ratio")));
        }
        // The strain of one cycle is bounded by the end conditions of the test.
        let (one_cycle, default_interval) = match by_stress {
            Some(_) => {
                let value = values.number("double_amplitude");
                until.push(Until::DoubleAmplitude { measure: Measure::Strain(0), value });
                (2.0 * value, INTERVAL_BY_STRESS)
            }
            None => (4.0 * amplitude, 4.0 * amplitude / STATES_OF_A_CYCLE),
        };
        let interval = values.optional("interval").unwrap_or(default_interval);
        let most = 2.0 * cycles * one_cycle + 4.0 * values.number("mean_strain").abs() + 0.2;
        let test = Stage {
            turns: Some(Turns { measure, high: middle + amplitude, low: middle - amplitude }),
            most_arc_length: Some(most),
            resets: true,
            ..Stage::new("cyclic", control(values), until)
                .recording(RecordedStates::every(Measure::ArcLength, interval))
        };
        values.consolidation("mean_stress").into_iter().chain([test]).collect()
    },
};

/// States recorded in a strain cycle, and the arc length between states of a test that is reversed at stresses.
const STATES_OF_A_CYCLE: f64 = 40.0;
const INTERVAL_BY_STRESS: f64 = 1e-4;

fn undrained(values: &PathValues) -> bool {
    values.is("drainage", "undrained")
}

/// With a strain amplitude the strain rate along x is prescribed. With a stress amplitude the rate of the deviator stress is
/// prescribed, and the strain rate is limited to the speed of the stage, which matters when the sample flows.
fn control(values: &PathValues) -> Control {
    let (free, fixed) = (Drive::Free, Drive::Fixed);
    let held = Drive::Stress(Target::current());
    let Some(amplitude) = values.optional("stress_amplitude") else {
        let lateral = if undrained(values) { Drive::Rate(-0.5) } else { held };
        return Control::new(values.speed(), [Drive::Rate(1.0), lateral, lateral, fixed, fixed, fixed]);
    };
    let first = Target::ramp(Ramp::To(values.number("mean_deviator_stress") + amplitude));
    let deviator = Constraint::stresses([1.0, -0.5, -0.5, 0.0, 0.0, 0.0], first);
    let control = if undrained(values) {
        Control::new(values.speed(), [free, free, free, fixed, fixed, fixed])
            .with(Constraint::strains([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 0.0))
            .with(Constraint::strains([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], 0.0))
    } else {
        Control::new(values.speed(), [free, held, held, fixed, fixed, fixed])
    };
    Control { servo_limit: 1.0, ..control.with(deviator) }
}

const PARAMETERS: &[PathParameter] = &[
    word(
        "drainage",
        "Control of the lateral axes.",
        &[
            ["undrained", "the volume is constant; stresses are effective stresses"],
            ["drained", "the lateral stresses are held"],
        ],
    ),
    number(
        "strain_amplitude",
        "Axial strain between the middle of a cycle and its turning points.",
        1e-3,
        [1e-7, 0.5],
    ),
    PathParameter {
        default: PathParameterDefault::Absent("the turning points are given by strain_amplitude"),
        ..stress(
            "stress_amplitude",
            "Deviator stress sigma_x - sigma_y between the middle of a cycle and its turning points, instead of \
             strain_amplitude.",
        )
    },
    number("mean_strain", "Axial strain in the middle of the cycles.", 0.0, [-1.0, 1.0]),
    deviator("mean_deviator_stress", "Deviator stress in the middle of the cycles of stress_amplitude."),
    number("cycles", "Number of cycles.", 10.0, [1.0, 1e6]),
    number(
        "pore_pressure_ratio",
        "Ratio r_u = 1 - p/p_0 of the excess pore pressure at which an undrained test ends: liquefaction.",
        0.95,
        [0.01, 1.0],
    ),
    number(
        "double_amplitude",
        "Axial strain since the last turning point at which a test with stress_amplitude ends.",
        0.05,
        [1e-5, 1.0],
    ),
    stress("mean_stress", "Mean effective stress to which the sample is consolidated first."),
    INERTIAL_NUMBER,
    optional(
        "interval",
        "Arc length of strain between recorded states.",
        "a fortieth of a strain cycle with strain_amplitude, 1e-4 with stress_amplitude",
        [1e-7, 1.0],
    ),
];
