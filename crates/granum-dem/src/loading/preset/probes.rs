//! Stress or strain probes: small equal increments in many directions from one state, for the response envelope of Gudehus
//! (1979) or the tangent stiffness.
//!
//! Every probe begins from the same saved state. Around the triaxial plane probe k has the direction
//! `(cos a, sin a / sqrt 2, sin a / sqrt 2)` of (x, y, z) with `a = 2 pi k / n`, so that all increments have one length.

use super::{INERTIAL_NUMBER, PathParameter, PathParameterDefault, PathValues, Preset, number, stress, word};
use crate::loading::{Control, Drive, Ramp, Stage, Start, Target, Until};

pub(super) const PRESET: Preset = Preset {
    name: "probes",
    help: "Small increments of strain or stress in many directions, each from the same state at rest: the response envelope.",
    own: PARAMETERS,
    faults: |values| values.both("strain", "stress").or_else(|| values.not_whole("directions")),
    stages: |values| {
        let held = Drive::Stress(Target::current());
        let control = Control { servo_limit: 1.0, ..Control::new(values.speed(), [held; 6]) };
        let rest = Until::AtRest { unbalanced_force: values.number("unbalanced_force") };
        let mut stages = vec![Stage { settling: true, ..Stage::new("rest", control, vec![rest]) }];
        for (k, (name, direction)) in directions(values).into_iter().enumerate() {
            let start = if k == 0 { Start::Kept } else { Start::Back };
            let stage = Stage::new(format!("probe {name}"), probe(values, &direction), vec![Until::RampOver]);
            stages.push(Stage { start, resets: true, most_arc_length: Some(0.05), ..stage });
            stages.push(Stage::mark(format!("response {name}")));
        }
        stages
    },
};

fn probe(values: &PathValues, direction: &[f64; 6]) -> Control {
    let by_stress = values.optional("stress");
    let size = by_stress.unwrap_or_else(|| values.number("strain"));
    let components = direction.map(|part| match by_stress {
        Some(_) => Drive::Stress(Target::ramp(Ramp::By(size * part))),
        None => Drive::Ramp(Ramp::By(size * part)),
    });
    Control::new(values.speed(), components)
}

/// Names and directions of the probes, by components.
fn directions(values: &PathValues) -> Vec<(String, [f64; 6])> {
    if values.is("around", "components") {
        let signed = |k: usize, sign: f64| {
            let mut direction = [0.0; 6];
            direction[k] = sign;
            (format!("{}{}", if sign > 0.0 { "+" } else { "-" }, crate::servo::COMPONENTS[k]), direction)
        };
        return (0..6).flat_map(|k| [signed(k, 1.0), signed(k, -1.0)]).collect();
    }
    let count = values.number("directions") as usize;
    let probe = |k: usize| {
        let share = k as f64 / count as f64;
        let [axial, lateral] = on_circle(share);
        let lateral = lateral * std::f64::consts::FRAC_1_SQRT_2;
        (format!("{:.0} degrees", 360.0 * share), [axial, lateral, lateral, 0.0, 0.0, 0.0])
    };
    (0..count).map(probe).collect()
}

/// Cosine and sine of a share of the full circle, by their series: the standard library's differ between machines.
fn on_circle(share: f64) -> [f64; 2] {
    let quarters = libm::round(4.0 * share);
    let angle = std::f64::consts::FRAC_PI_2 * (4.0 * share - quarters);
    let square = angle * angle;
    // Horner's scheme; |angle| is at most pi / 4, so that ten terms are exact to rounding.
    let series = |from: u32| {
        let term = |sum: f64, k: u32| 1.0 - sum * square / f64::from((2 * k + from) * (2 * k + from - 1));
        (1..=10).rev().fold(1.0, term)
    };
    let (cos, sin) = (series(0), angle * series(1));
    match (quarters as i64).rem_euclid(4) {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

const PARAMETERS: &[PathParameter] = &[
    word(
        "around",
        "Directions of the probes.",
        &[
            ["triaxial-plane", "equal angles in the plane of the axial and the two equal lateral components"],
            ["components", "each of the six components in both senses, for the tangent stiffness"],
        ],
    ),
    number("directions", "Number of directions in the triaxial plane.", 12.0, [1.0, 360.0]),
    number("strain", "Length of the strain increments; shear strains are angles.", 1e-5, [1e-9, 0.01]),
    PathParameter {
        default: PathParameterDefault::Absent("increments of strain"),
        ..stress("stress", "Length of the stress increments, instead of strain.")
    },
    number(
        "unbalanced_force",
        "Unbalanced force over the mean contact force below which the sample is at rest before the probes.",
        1e-4,
        [1e-9, 1.0],
    ),
    PathParameter { default: PathParameterDefault::Value(1e-4), ..INERTIAL_NUMBER },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_lie_on_the_circle() {
        for k in 0..360 {
            let share = f64::from(k) / 360.0;
            let angle = 2.0 * std::f64::consts::PI * share;
            let [cos, sin] = on_circle(share);
            assert!((cos - angle.cos()).abs() < 1e-14 && (sin - angle.sin()).abs() < 1e-14, "{k}");
        }
    }
}
