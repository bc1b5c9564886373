//! Ellipsoids of spheres that touch them from inside.
//!
//! In an ellipsoid of the semi-lengths `a >= b >= c` a sphere with its centre (x, y, 0) that touches it from inside has the radius
//! `R^2 = c^2 (1 - x^2/(a^2 - c^2) - y^2/(b^2 - c^2))`, and touches it at `X = x a^2/(a^2 - c^2)`, `Y = y b^2/(b^2 - c^2)`. Such centres fill the medial
//! ellipse of the semi-lengths `(a^2 - c^2)/a` and `(b^2 - c^2)/b`; at its rim the sphere has the least radius of curvature of the ellipsoid there. For
//! a prolate ellipsoid, `b = c`, the medial ellipse is a part of the long axis.

use crate::entry::ShapeEntry;
use crate::families::capsule::PIECES;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};
use crate::union_of_spheres::connected::islands;

/// An ellipsoid. Its spheres lie on its medial ellipse: in a row along a narrow one, else in rings with as many spheres as their length asks
/// for, with the two planes of symmetry of the ellipse.
pub struct Ellipsoid;

/// Intermediate over largest length, which several families have.
pub(crate) const ELONGATION: ShapeParameter = ShapeParameter {
    key: "elongation",
    default: 0.8,
    bounds: [0.2, 1.0],
    whole: false,
    meaning: "Intermediate over largest length, b/a: 1 is as wide as long.",
};

/// Least over intermediate length, which several families have.
pub(crate) const FLATNESS: ShapeParameter = ShapeParameter {
    key: "flatness",
    default: 0.8,
    bounds: [0.2, 1.0],
    whole: false,
    meaning: "Least over intermediate length, c/b: 1 is as thick as wide.",
};

/// Number of spheres.
const SPHERES: ShapeParameter = ShapeParameter { default: 20.0, ..PIECES };

/// Proportions whose difference is below this count as equal.
const EQUAL: f64 = 1e-6;

impl ShapeFamily for Ellipsoid {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "ellipsoid",
            help: "spheres that touch an ellipsoid from inside",
            parameters: &[ELONGATION, FLATNESS, SPHERES],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let (b, pieces) = (given.value(&ELONGATION), given.value(&SPHERES));
        let spheres = spheres(b, b * given.value(&FLATNESS), pieces as usize);
        if islands(&spheres).is_some() {
            let message = format!("is {pieces}: so few spheres would not touch in this ellipsoid; take more");
            return Err(ShapeError::new("pieces", message));
        }
        Ok(vec![spheres])
    }
}

/// Spheres in the ellipsoid of the semi-lengths 1, b, c.
fn spheres(b: f64, c: f64, pieces: usize) -> Spheres {
    let [long, wide] = [1.0 - c * c, (b * b - c * c) / b];
    if long < EQUAL {
        return vec![([0.0; 3], c)];
    }
    let sphere = |[x, y]: [f64; 2]| {
        // In terms of the point of contact X, Y: R^2 = c^2 (1 - X^2 (1 - c^2) - Y^2 (b^2 - c^2)/b^4).
        let square = 1.0 - x * x * long - if wide > EQUAL { y * y * wide / b } else { 0.0 };
        ([x * long, y * wide, 0.0], c * square.max(0.0).sqrt())
    };
    layout(long, wide, pieces).into_iter().map(sphere).collect()
}

/// Places on a medial ellipse over its semi-lengths, so that its rim is the unit circle.
fn layout(long: f64, wide: f64, pieces: usize) -> Vec<[f64; 2]> {
    // Spacing of pieces spread over the ellipse and its rim.
    let area = std::f64::consts::PI * long * wide;
    let spacing = (area / pieces as f64).sqrt();
    if wide < 0.5 * long && wide < 1.2 * spacing || wide < EQUAL {
        return row(pieces);
    }
    let rings = ((0.5 * (long + wide) / spacing).floor() as usize).clamp(1, pieces / 2);
    let mut places = if pieces % 2 == 1 { vec![[0.0; 2]] } else { Vec::new() };
    let pairs = pieces / 2;
    // The pairs before the ring k are as many as the area within it.
    let before = |k: usize| ((pairs * k * (k + 1)) as f64 / (rings * (rings + 1)) as f64).round() as usize;
    for ring in 1..=rings {
        let count = 2 * (before(ring) - before(ring - 1));
        let radius = ring as f64 / rings as f64;
        places.extend(on_ring(long, wide, count).into_iter().map(|place| place.map(|x| radius * x)));
    }
    places
}

/// Places along the long axis, denser towards its ends, where the spheres are smaller.
fn row(pieces: usize) -> Vec<[f64; 2]> {
    let last = (pieces - 1) as f64;
    // Antisymmetric in k without rounding.
    (0..pieces)
        .map(|k| {
            let t = (2.0 * k as f64 - last) / last;
            [libm::sin(0.5 * std::f64::consts::PI * t), 0.0]
        })
        .collect()
}

/// Places evenly along the rim of an ellipse, an even number of them, with its two planes of symmetry.
fn on_ring(long: f64, wide: f64, count: usize) -> Vec<[f64; 2]> {
    const PARTS: usize = 720;
    let point = |k: usize| {
        let (sine, cosine) = libm::sincos(0.5 * std::f64::consts::PI * k as f64 / PARTS as f64);
        [cosine, sine]
    };
    // Length of the rim up to each of the parts of a quarter.
    let mut along = vec![0.0];
    for k in 0..PARTS {
        let ([x, y], [u, v]) = (point(k), point(k + 1));
        let (dx, dy) = (long * (u - x), wide * (v - y));
        along.push(along[k] + (dx * dx + dy * dy).sqrt());
    }
    let quarter = along[PARTS];
    let at = |length: f64| {
        let k = along.partition_point(|x| *x < length).clamp(1, PARTS);
        let share = (length - along[k - 1]) / (along[k] - along[k - 1]);
        let angle = 0.5 * std::f64::consts::PI * ((k - 1) as f64 + share) / PARTS as f64;
        let (sine, cosine) = libm::sincos(angle);
        [cosine, sine]
    };
    let mut places = Vec::new();
    // Of each place in the first quarter there are two or four images.
    let half = count / 2;
    for k in 0..=half / 2 {
        let length = 2.0 * quarter * k as f64 / half as f64;
        match k {
            0 => places.extend([[1.0, 0.0], [-1.0, 0.0]]),
            _ if 2 * k == half => places.extend([[0.0, 1.0], [0.0, -1.0]]),
            _ => {
                let [x, y] = at(length);
                places.extend([[x, y], [-x, y], [-x, -y], [x, -y]]);
            }
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::ShapeKind;
    use crate::union_of_spheres::ShapeOfSpheres;

    const CASES: [[f64; 2]; 7] =
        [[0.5, 1.0], [1.0, 0.5], [0.8, 0.7], [0.4, 0.6], [0.9, 0.95], [0.2, 0.2], [0.6, 0.999]];

    fn made([elongation, flatness]: [f64; 2], pieces: usize) -> Spheres {
        let entry = ShapeEntry::new(ShapeKind::ELLIPSOID)
            .with("elongation", elongation)
            .with("flatness", flatness)
            .with("pieces", pieces as f64);
        entry.check().unwrap();
        spheres(entry.value(&ELONGATION), entry.value(&ELONGATION) * entry.value(&FLATNESS), pieces)
    }

    /// Over many directions of a sphere the largest `X^2 + Y^2/b^2 + Z^2/c^2` is one: it is inside the ellipsoid and touches it.
    #[test]
    fn every_sphere_is_inside_and_touches() {
        for case in CASES {
            let (b, c) = (case[0], case[0] * case[1]);
            for (centre, radius) in made(case, 20) {
                // The point of contact is where the normal of the ellipsoid is along the radius.
                let long = 1.0 - c * c;
                let (x, wide) = (centre[0] / long, (b * b - c * c) / (b * b));
                let y = if wide > 1e-9 { centre[1] / wide } else { 0.0 };
                let z2 =
                    radius * radius - (x - centre[0]) * (x - centre[0]) - (y - centre[1]) * (y - centre[1]);
                assert!(z2 > -1e-12, "{case:?}");
                let level = x * x + y * y / (b * b) + z2 / (c * c);
                assert!((level - 1.0).abs() < 1e-9, "{case:?}: {level}");
                let units = &crate::directions::directions(4).units;
                let out = units.iter().map(|u| {
                    let p: [f64; 3] = std::array::from_fn(|a| centre[a] + radius * u[a]);
                    p[0] * p[0] + p[1] * p[1] / (b * b) + p[2] * p[2] / (c * c)
                });
                let most = out.fold(0.0, f64::max);
                assert!(most < 1.0 + 1e-9 && most > 0.9, "{case:?}: {most}");
            }
        }
    }

    /// The number of spheres is the one asked for, they are symmetric, and their volume approaches that of the ellipsoid from below.
    #[test]
    fn the_volume_approaches_with_more_pieces() {
        for case in CASES {
            let volume = 4.0 / 3.0 * std::f64::consts::PI * case[0] * case[0] * case[1];
            let mut last = 0.0;
            for pieces in [4, 9, 21, 60, 200] {
                let spheres = made(case, pieces);
                assert_eq!(spheres.len(), pieces, "{case:?}");
                let shape = ShapeOfSpheres::new(&spheres).unwrap();
                let share = shape.shape.volume / volume;
                assert!(share < 1.0 + 1e-9 && share > last - 1e-3, "{case:?} {pieces}: {share}");
                assert!(shape.centre.iter().all(|x| x.abs() < 1e-9), "{case:?}");
                last = share;
            }
            // A needle as flat as a blade has 25 times the length of its thickness.
            let least = if case == [0.2, 0.2] { 0.4 } else { 0.96 };
            assert!(last > least, "{case:?}: {last}");
        }
    }

    #[test]
    fn equal_lengths_are_a_sphere_and_too_few_spheres_are_refused() {
        assert_eq!(made([1.0, 1.0], 20), vec![([0.0; 3], 1.0)]);
        let blade = ShapeEntry::new(ShapeKind::ELLIPSOID).with("elongation", 0.2).with("flatness", 0.2);
        let said = blade.clone().with("pieces", 4.0).shapes().unwrap_err().to_string();
        assert!(said.starts_with("pieces is 4: so few spheres would not touch"), "{said}");
        let flat = ShapeEntry::new(ShapeKind::ELLIPSOID).with("elongation", 0.5).with("flatness", 0.5);
        assert!(flat.with("pieces", 60.0).shapes().is_ok());
    }
}
