//! Seams: where two spheres of a shape meet, a grain that slides along must climb out of a groove.

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, dot, length};

use crate::rigid_shape::RigidShape;

/// Number of points of a groove at which it is asked whether other spheres fill it.
const POINTS: usize = 32;

/// The slope `tan(chi)` of the widest seam of a shape, which acts as friction; `None` where no seam can be touched, as of a sphere.
///
/// A sphere of radius p that touches two spheres of the radii r and s, whose centres are at the distance c, has its centre at the distances
/// `a = r + p` and `b = s + p` from theirs. The normals of both contacts enclose the angle `2 chi`, `sin(chi)^2 = (c^2 - (a - b)^2)/(4 a b)`.
/// With the mean radius p, two spheres of one diameter d have `sin(chi) = c/2d`. Seams that other spheres fill do not count.
pub fn widest_seam(shape: &RigidShape) -> Option<f64> {
    let pieces = &shape.pieces;
    let mut widest: Option<f64> = None;
    for (k, one) in pieces.iter().enumerate() {
        for (j, other) in pieces.iter().enumerate().skip(k + 1) {
            let probe = 0.5 * (one.radius + other.radius);
            let apart: Vector = std::array::from_fn(|i| other.centre[i] - one.centre[i]);
            let (distance, [a, b]) = (length(&apart), [one.radius + probe, other.radius + probe]);
            if distance >= one.radius + other.radius || distance <= (a - b).abs() {
                continue;
            }
            let square = ((distance * distance - (a - b) * (a - b)) / (4.0 * a * b)).clamp(0.0, 1.0 - 1e-12);
            let slope = (square / (1.0 - square)).sqrt();
            if widest.is_some_and(|widest| widest >= slope) {
                continue;
            }
            let filled = |place: &Vector| {
                let inside = |(i, piece): (usize, &crate::rigid_shape::ShapePiece)| {
                    let from: Vector = std::array::from_fn(|n| place[n] - piece.centre[n]);
                    i != k && i != j && length(&from) < (piece.radius + probe) * (1.0 - 1e-9)
                };
                pieces.iter().enumerate().any(inside)
            };
            let along = (distance * distance + a * a - b * b) / (2.0 * distance);
            let radius = (a * a - along * along).max(0.0).sqrt();
            if circle(&one.centre, &apart.map(|x| x / distance), along, radius).any(|place| !filled(&place)) {
                widest = Some(slope);
            }
        }
    }
    widest
}

/// Points of a circle about an axis, at a distance along it.
fn circle(from: &Vector, axis: &Vector, along: f64, radius: f64) -> impl Iterator<Item = Vector> {
    let least = (1..3).fold(0, |least, k| if axis[k].abs() < axis[least].abs() { k } else { least });
    let mut across = [0.0; 3];
    across[least] = 1.0;
    let first = cross(axis, &across);
    let first = first.map(|x| x / length(&first));
    let second = cross(axis, &first);
    debug_assert!(dot(&first, axis).abs() < 1e-9);
    let middle: Vector = std::array::from_fn(|k| from[k] + along * axis[k]);
    (0..POINTS).map(move |k| {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * (k as f64 + 0.5) / POINTS as f64);
        std::array::from_fn(|n| middle[n] + radius * (cosine * first[n] + sine * second[n]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entry::ShapeEntry;
    use crate::family::ShapeKind;

    fn slope(entry: ShapeEntry) -> Option<f64> {
        widest_seam(&entry.shapes().unwrap()[0].shape)
    }

    /// The numbers of the documentation of capsules: `sin(chi) = c/2d`.
    #[test]
    fn seams_of_capsules_are_those_of_theory() {
        let capsule = ShapeEntry::new(ShapeKind::CAPSULE).with("aspect_ratio", 2.0);
        for (pieces, spacing) in [(3.0, 0.5), (11.0, 0.1)] {
            let sine: f64 = 0.5 * spacing;
            let found = slope(capsule.clone().with("pieces", pieces)).unwrap();
            assert!((found - sine / (1.0 - sine * sine).sqrt()).abs() < 1e-12, "{pieces}: {found}");
        }
        assert_eq!(slope(ShapeEntry::default()), None);
    }

    /// Two small spheres that meet inside a large one have no seam that can be touched.
    #[test]
    fn a_seam_that_others_fill_does_not_count() {
        let entry = |spheres: &[[f64; 4]]| ShapeEntry {
            spheres: spheres.to_vec(),
            ..ShapeEntry::new(ShapeKind::PIECES)
        };
        let two = [[-0.6, 0.0, 0.0, 0.7], [0.6, 0.0, 0.0, 0.7]];
        let alone = slope(entry(&two)).unwrap();
        let filled = slope(entry(&[two[0], two[1], [0.0, 0.0, 0.0, 1.0]])).unwrap();
        assert!(filled < 0.6 * alone, "{alone} {filled}");
    }
}
