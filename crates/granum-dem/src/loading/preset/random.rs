//! Random path of deviatoric strain from a seed, for surrogates that must know any path: at constant mean stress, at constant volume, or while the mean
//! stress goes from one random value to another.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{
    INERTIAL_NUMBER, INTERVAL, PathFault, PathParameter, PathParameterDefault, PathValues, Preset, number,
    stress, word,
};
use crate::loading::{Constraint, Control, Drive, Measure, RecordedStates, Speed, Stage, Target, Until};
use crate::random::unit;

pub(super) const PRESET: Preset = Preset {
    name: "random",
    help: "Deviatoric strains along a path of straight lines that a seed decides, at constant or changing mean stress or at constant \
           volume: turning points anywhere, one line, cycles, or all of them in turn.",
    own: PARAMETERS,
    faults: |values| {
        let (length, amplitude) = (values.number("length"), values.number("amplitude"));
        let too_long = || {
            let message = || {
                format!(
                    "length = {length} must be at most {MOST_AMPLITUDES} times amplitude, which is {amplitude}"
                )
            };
            (length > MOST_AMPLITUDES * amplitude).then(|| ("length", message()))
        };
        values.not_whole("seed").or_else(too_long).or_else(|| fault_of_mean_stress(values))
    },
    stages: |values| {
        let kinds = [("monotonic", Kind::Monotonic), ("cyclic", Kind::Cyclic), ("mixed", Kind::Mixed)];
        let chosen = kinds.into_iter().find(|(name, _)| values.is("kind", name));
        let kind = chosen.map_or(Kind::Random, |(_, kind)| kind);
        let [amplitude, length] = ["amplitude", "length"].map(|key| values.number(key));
        let seed = values.number("seed") as u64;
        let points = turning_points(kind, seed, amplitude, length);
        let stresses = mean_stresses(values, seed, points.len());
        let record = RecordedStates::every(Measure::ArcLength, values.number("interval"));
        let lines = points.windows(2).enumerate().map(|(k, ends)| {
            let [from, to] = [ends[0], ends[1]];
            let distance = norm(&minus(&to, &from));
            let volume = match stresses.get(k..k + 2) {
                _ if values.is("drainage", "undrained") => Constraint::strains(VOLUME, 0.0),
                Some(ends) => moving_mean_stress(&from, &to, [ends[0], ends[1]]),
                None => Constraint::mean_stress(values.target("mean_stress")),
            };
            let mut control = control(&minus(&to, &from), distance).with(volume);
            control.speed = speed(values);
            let stage = Stage::new(format!("line {}", k + 1), control, vec![end(&from, &to)]);
            let most_arc_length = Some(2.0 * distance + 0.01);
            Stage { resets: k == 0, most_arc_length, record: record.clone(), ..stage }
        });
        let first = values.consolidation("mean_stress");
        first.into_iter().chain(lines).chain([Stage::mark("end")]).collect()
    },
};

/// Longest path, in amplitudes, so that the number of its lines is bounded.
const MOST_AMPLITUDES: f64 = 1000.0;

/// Smallest share of the amplitude that cycles have.
const LEAST_CYCLE: f64 = 0.25;

/// The weights of the normal strains in the volumetric strain.
const VOLUME: [f64; 6] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];

#[derive(Clone, Copy)]
enum Kind {
    Random,
    Monotonic,
    Cyclic,
    Mixed,
}

/// A deviatoric strain in an orthogonal basis, whose norm is `sqrt(2/3 e:e)`: `e_xx = c_0`,
/// `e_yy = -c_0 / 2 + sqrt(3)/2 c_1`, `e_zz = -c_0 / 2 - sqrt(3)/2 c_1`, and the shear angles yz, zx and xy are `sqrt(3)`
/// times the other three.
type Point = [f64; 5];

fn minus(a: &Point, b: &Point) -> Point {
    std::array::from_fn(|k| a[k] - b[k])
}

fn along(from: &Point, factor: f64, direction: &Point) -> Point {
    std::array::from_fn(|k| from[k] + factor * direction[k])
}

fn norm(point: &Point) -> f64 {
    point.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// A point of uniform density in the ball of radius one.
fn in_ball(random: &mut ChaCha8Rng) -> Point {
    loop {
        let point: Point = std::array::from_fn(|_| 2.0 * unit(random) - 1.0);
        if norm(&point) <= 1.0 {
            return point;
        }
    }
}

/// A direction of uniform density.
fn direction(random: &mut ChaCha8Rng) -> Point {
    loop {
        let point = in_ball(random);
        let length = norm(&point);
        if length > 0.01 {
            return point.map(|c| c / length);
        }
    }
}

/// Points that are passed along straight lines, until the path has its length.
struct Way {
    points: Vec<Point>,
    length: f64,
    left: f64,
}

impl Way {
    /// True if what is left is no more than rounding.
    fn is_over(&self) -> bool {
        self.left <= 1e-9 * self.length
    }

    fn at(&self) -> Point {
        self.points.last().copied().unwrap_or_default()
    }

    /// Goes on to a point, or as far towards it as the length allows.
    fn to(&mut self, point: Point) {
        let line = minus(&point, &self.at());
        let distance = norm(&line);
        if self.is_over() || distance <= 0.0 {
            return;
        }
        self.points.push(along(&self.at(), (self.left / distance).min(1.0), &line));
        self.left -= distance;
    }
}

/// The turning points, from the origin on.
fn turning_points(kind: Kind, seed: u64, amplitude: f64, length: f64) -> Vec<Point> {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let origin = Point::default();
    let mut way = Way { points: vec![origin], length, left: length };
    let axis = direction(random);
    let half = amplitude * (LEAST_CYCLE + (1.0 - LEAST_CYCLE) * unit(random));
    while !way.is_over() {
        match kind {
            Kind::Monotonic => way.to(along(&origin, length, &axis)),
            Kind::Cyclic => {
                way.to(along(&origin, half, &axis));
                way.to(along(&origin, -half, &axis));
            }
            Kind::Random => way.to(along(&origin, amplitude, &in_ball(random))),
            Kind::Mixed => match (3.0 * unit(random)) as usize {
                0 => way.to(along(&origin, amplitude, &in_ball(random))),
                1 => way.to(along(&origin, amplitude, &direction(random))),
                _ => {
                    let (middle, axis) = (way.at(), direction(random));
                    let half = amplitude * (0.1 + 0.2 * unit(random));
                    for _ in 0..1 + (3.0 * unit(random)) as usize {
                        way.to(along(&middle, half, &axis));
                        way.to(along(&middle, -half, &axis));
                    }
                    way.to(middle);
                }
            },
        }
    }
    way.points
}

/// The control along a line of the given length: all deviatoric strain rates are prescribed, the volume is free.
fn control(line: &Point, length: f64) -> Control {
    let root = 3f64.sqrt();
    let rate = line.map(|c| c / length);
    let [yy, zz] = [1.0, -1.0].map(|sign| -0.5 * rate[0] + sign * 0.5 * root * rate[1]);
    let (free, shear) = (Drive::Free, |k: usize| Drive::Rate(root * rate[k] + 0.0));
    let components = [free, free, free, shear(2), shear(3), shear(4)];
    Control { components, ..Control::default() }
        .with(Constraint::strains([1.0, -1.0, 0.0, 0.0, 0.0, 0.0], rate[0] - yy))
        .with(Constraint::strains([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], yy - zz))
}

/// Of the strains that are measured exactly, the one that changes most along a line: its place in a [`Point`], and the factor of the coordinate in it.
fn leading(from: &Point, to: &Point) -> (usize, f64) {
    let root = 3f64.sqrt();
    let measures = [(0, 1.5), (2, root), (3, root), (4, root)];
    let change = |(k, factor): &(usize, f64)| factor * (to[*k] - from[*k]).abs();
    measures.into_iter().max_by(|a, b| change(a).total_cmp(&change(b))).unwrap_or((0, 1.5))
}

/// The end of a line: the strain that changes most reaches its value, so that errors do not add up over many lines.
fn end(from: &Point, to: &Point) -> Until {
    let (k, factor) = leading(from, to);
    let measure = match k {
        0 => Measure::AxialDeviatorStrain,
        _ => Measure::Strain(k as u8 + 1),
    };
    Until::Reaches { measure, value: factor * to[k] }
}

/// The speed: at constant volume the mean stress may vanish, and with it the rate that belongs to an inertial number, so that the first one counts.
fn speed(values: &PathValues) -> Speed {
    let at = values.optional("mean_stress").filter(|_| values.is("drainage", "undrained"));
    match values.speed() {
        Speed::InertialNumber { number, .. } => Speed::InertialNumber { number, at },
        rate => rate,
    }
}

/// The mean stresses at the turning points, Pa, of which the first is that of the sample and the logarithms of the others have a uniform density; none
/// where the mean stress is held or the volume is.
fn mean_stresses(values: &PathValues, seed: u64, count: usize) -> Vec<f64> {
    let [first, low, high] = STRESSES.map(|key| values.optional(key));
    let (true, Some(first), Some(low), Some(high)) = (values.is("drainage", "moving"), first, low, high)
    else {
        return Vec::new();
    };
    // The numbers of the turning points are another stream, so that a seed has one path of strain.
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(1);
    let others = (1..count).map(|_| low * libm::pow(high / low, unit(random)));
    std::iter::once(first).chain(others).collect()
}

/// The constraint that the mean stress goes from one value to another along a line, in proportion to the strain that changes most: a combination of the
/// stresses and of that strain is held.
fn moving_mean_stress(from: &Point, to: &Point, [first, last]: [f64; 2]) -> Constraint {
    let (k, factor) = leading(from, to);
    let slope = 3.0 * (last - first) / (factor * (to[k] - from[k]));
    let mut strain = [0.0; 6];
    match k {
        0 => [strain[0], strain[1], strain[2]] = [-slope, 0.5 * slope, 0.5 * slope],
        _ => strain[k + 1] = -slope,
    }
    let target = Target::held(3.0 * first - slope * factor * from[k]);
    Constraint { strain, ..Constraint::mean_stress(target) }
}

/// The mean stress at the start and its bounds.
const STRESSES: [&str; 3] = ["mean_stress", "lowest_mean_stress", "highest_mean_stress"];

/// What is wrong with the mean stresses, where they move.
fn fault_of_mean_stress(values: &PathValues) -> Option<PathFault> {
    let [first, lowest, highest] = STRESSES;
    if !values.is("drainage", "moving") {
        return None;
    }
    if values.optional(first).is_none() {
        return Some((
            "drainage",
            format!("drainage = \"moving\" needs {first}, from which the mean stress goes on"),
        ));
    }
    let [low, high] = [lowest, highest].map(|key| values.number(key));
    (low > high).then(|| (lowest, format!("{lowest} = {low} must be at most {highest}, which is {high}")))
}

const PARAMETERS: &[PathParameter] = &[
    word(
        "kind",
        "What the path consists of.",
        &[
            [
                "random",
                "straight lines between points anywhere in the ball of all deviatoric strains up to amplitude",
            ],
            ["monotonic", "one straight line in a random direction"],
            [
                "cyclic",
                "cycles in a random direction, with an amplitude between a quarter of amplitude and amplitude",
            ],
            [
                "mixed",
                "random points, points at the amplitude, and one to three small cycles, in random order",
            ],
        ],
    ),
    number("seed", "Whole number that decides the path.", 1.0, [0.0, 9e15]),
    number(
        "amplitude",
        "Largest deviatoric strain sqrt(2/3 e:e) from the start of the path.",
        0.01,
        [1e-6, 1.0],
    ),
    number("length", "Length of the path: the sum of sqrt(2/3 de:de) over its lines.", 0.1, [1e-6, 100.0]),
    word(
        "drainage",
        "What happens to the volume and the mean stress.",
        &[
            ["drained", "the mean stress is held and the volume is free"],
            ["undrained", "the volume is constant"],
            [
                "moving",
                "along each line the mean stress goes to a random value from lowest_mean_stress to highest_mean_stress, of uniform density in its logarithm",
            ],
        ],
    ),
    stress(
        "mean_stress",
        "Mean stress p, to which the sample is consolidated first and which is then held, unless drainage says otherwise.",
    ),
    PathParameter {
        default: PathParameterDefault::Value(20e3),
        ..stress("lowest_mean_stress", "Lowest mean stress of a turning point, where the mean stress moves.")
    },
    PathParameter {
        default: PathParameterDefault::Value(500e3),
        ..stress(
            "highest_mean_stress",
            "Highest mean stress of a turning point, where the mean stress moves.",
        )
    },
    PathParameter {
        help: "Speed: inertial number I of the rate of the deviatoric strain at the mean stress at the start of each line, undrained at mean_stress.",
        ..INERTIAL_NUMBER
    },
    PathParameter {
        help: "Arc length of strain between the states that are recorded along a line; the turning points are recorded too.",
        default: PathParameterDefault::Value(1e-3),
        ..INTERVAL
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loading::preset::Given;

    fn given(values: &[(&str, f64)], drainage: &str) -> Given {
        let numbers = values.iter().map(|(key, value)| ((*key).to_string(), (*value).into()));
        numbers.chain([("drainage".to_string(), drainage.into())]).collect()
    }

    #[test]
    fn a_moving_mean_stress_has_its_value_at_every_turning_point() {
        let bounds = [("mean_stress", 100e3), ("lowest_mean_stress", 20e3), ("highest_mean_stress", 500e3)];
        let moving = given(&bounds, "moving");
        assert_eq!(PRESET.fault(&moving), None);
        let values = PathValues { preset: &PRESET, given: &moving };
        let stresses = mean_stresses(&values, 1, 4000);
        assert_eq!(stresses[0], 100e3);
        assert!(stresses.iter().all(|p| (20e3..=500e3).contains(p)));
        // The median of logarithms of uniform density is the geometric mean.
        let below = stresses.iter().filter(|p| **p < 100e3).count();
        assert!((1850..2150).contains(&below), "{below}");
        let points = turning_points(Kind::Random, 1, 0.01, 0.1);
        let six = |c: &Point| {
            let (half, root) = (-0.5 * c[0], 3f64.sqrt());
            [c[0], half + 0.5 * root * c[1], half - 0.5 * root * c[1], root * c[2], root * c[3], root * c[4]]
        };
        for (ends, p) in points.windows(2).zip(stresses.windows(2)) {
            let held = moving_mean_stress(&ends[0], &ends[1], [p[0], p[1]]);
            for (point, p) in ends.iter().zip(p) {
                let of_strain: f64 =
                    held.strain.iter().zip(six(point)).map(|(weight, strain)| weight * strain).sum();
                assert!((3.0 * p + of_strain - held.target.value.unwrap()).abs() < 1e-6, "{p}");
            }
        }
        // The path of strain is that of the same seed at constant mean stress.
        let ends = |stages: &[Stage]| stages.iter().map(|stage| stage.until.clone()).collect::<Vec<_>>();
        let drained = given(&bounds[..1], "drained");
        assert_eq!(ends(&PRESET.expand(&moving)), ends(&PRESET.expand(&drained)));
    }

    #[test]
    fn a_moving_mean_stress_needs_a_start_and_bounds() {
        let fault = |values: &[(&str, f64)], drainage: &str| {
            PRESET.fault(&given(values, drainage)).map(|(key, _)| key)
        };
        assert_eq!(fault(&[("lowest_mean_stress", 2e4)], "moving"), Some("drainage"));
        let turned = [("mean_stress", 1e5), ("lowest_mean_stress", 5e5), ("highest_mean_stress", 2e4)];
        assert_eq!(fault(&turned, "moving"), Some("lowest_mean_stress"));
        assert_eq!(fault(&turned, "undrained"), None);
    }

    #[test]
    fn a_seed_decides_a_path_of_its_length_within_its_amplitude() {
        for (kind, reach) in
            [(Kind::Random, 0.01), (Kind::Monotonic, 0.2), (Kind::Cyclic, 0.01), (Kind::Mixed, 0.013)]
        {
            // The sum of rounded lengths may stay below the length: every seed ends nevertheless.
            (0..200).for_each(|seed| drop(turning_points(kind, seed, 0.01, 0.2)));
            let points = turning_points(kind, 7, 0.01, 0.2);
            let length: f64 = points.windows(2).map(|ends| norm(&minus(&ends[1], &ends[0]))).sum();
            assert!((length - 0.2).abs() < 1e-12, "{length}");
            assert!(points.iter().all(|point| norm(point) <= reach * (1.0 + 1e-12)));
            assert_eq!(points, turning_points(kind, 7, 0.01, 0.2));
            assert_ne!(points, turning_points(kind, 8, 0.01, 0.2));
        }
        // Cycles return to the same two points.
        let cycles = turning_points(Kind::Cyclic, 3, 0.01, 0.2);
        assert!(cycles.len() > 6 && cycles[1] == cycles[3] && cycles[2] == cycles[4]);
    }

    #[test]
    fn directions_are_as_often_in_one_component_as_in_another() {
        let random = &mut ChaCha8Rng::seed_from_u64(1);
        let mut squares = [0.0; 5];
        for _ in 0..4000 {
            let axis = direction(random);
            assert!((norm(&axis) - 1.0).abs() < 1e-12);
            (0..5).for_each(|k| squares[k] += axis[k] * axis[k] / 4000.0);
        }
        assert!(squares.iter().all(|mean| (mean - 0.2).abs() < 0.02), "{squares:?}");
    }
}
