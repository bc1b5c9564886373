//! The bounding box of least volume of a union of spheres.
//!
//! The extent of a union of spheres along a unit vector u is `max(c.u + r) - max(-c.u + r)` exactly, so that only the orientation is sought:
//! first among evenly spread ones and the principal axes, then from the best of them by ever smaller turns.

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, dot};

use crate::directions::{directions, steps, unit};
use crate::rigid_shape::ShapePiece;

/// Number of orientations about each direction, over a right angle.
const TURNS: usize = 12;
/// Number of orientations from which the search goes on.
const STARTS: usize = 8;
/// First and last turn of the search, rad.
const TURN: [f64; 2] = [0.08, 1e-7];

/// Three unit vectors at right angles.
type Frame = [Vector; 3];

/// The lengths of the bounding box of least volume, in falling order, m. The search finds it but for rounding where few orientations compete;
/// its volume is never below the least.
pub(crate) fn least_box(pieces: &[ShapePiece]) -> Vector {
    let mut tried: Vec<(f64, Frame)> = orientations().map(|frame| (volume(pieces, &frame), frame)).collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = tried[0];
    for start in tried.iter().take(STARTS) {
        let found = refined(pieces, *start);
        if found.0 < best.0 {
            best = found;
        }
    }
    let mut lengths = best.1.map(|axis| extent(pieces, &axis));
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths
}

/// The length of a union of spheres along a unit vector, m.
pub(crate) fn extent(pieces: &[ShapePiece], axis: &Vector) -> f64 {
    let ends = pieces.iter().fold([f64::MIN; 2], |[high, low], piece| {
        let along = dot(&piece.centre, axis);
        [high.max(along + piece.radius), low.max(piece.radius - along)]
    });
    ends[0] + ends[1]
}

fn volume(pieces: &[ShapePiece], frame: &Frame) -> f64 {
    frame.iter().map(|axis| extent(pieces, axis)).product()
}

/// The principal axes, and evenly spread orientations.
fn orientations() -> impl Iterator<Item = Frame> {
    let own = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let half = |u: &&Vector| u[2] > 0.0 || (u[2] == 0.0 && u[1] > 0.0);
    let about = |first: Vector| {
        let least = (0..3).min_by(|&a, &b| first[a].abs().total_cmp(&first[b].abs())).unwrap_or(0);
        let other = std::array::from_fn(|a| if a == least { 1.0 } else { 0.0 });
        let second = unit(&cross(&first, &other));
        let frame = [first, second, cross(&first, &second)];
        (0..TURNS)
            .map(move |k| turned(&frame, &[0.5 * std::f64::consts::PI * k as f64 / TURNS as f64, 0.0, 0.0]))
    };
    std::iter::once(own).chain(directions(2).units.iter().filter(half).copied().flat_map(about))
}

/// A frame turned by an angle about one of its own axes, or about the sum of several.
fn turned(frame: &Frame, angles: &Vector) -> Frame {
    let angle = dot(angles, angles).sqrt();
    if angle == 0.0 {
        return *frame;
    }
    let axis: Vector = std::array::from_fn(|a| (0..3).map(|k| angles[k] / angle * frame[k][a]).sum());
    let (sine, cosine) = libm::sincos(angle);
    // Rodrigues' formula.
    frame.map(|v| {
        let (across, along) = (cross(&axis, &v), dot(&axis, &v) * (1.0 - cosine));
        std::array::from_fn(|a| v[a] * cosine + across[a] * sine + axis[a] * along)
    })
}

/// The best orientation near one, by turns that become smaller whenever none is better.
fn refined(pieces: &[ShapePiece], (mut least, mut frame): (f64, Frame)) -> (f64, Frame) {
    let mut turn = TURN[0];
    while turn > TURN[1] {
        let tries = steps().map(|step| turned(&frame, &step.map(|x| x * turn)));
        let better = tries.map(|next| (volume(pieces, &next), next)).min_by(|a, b| a.0.total_cmp(&b.0));
        match better {
            Some((volume, next)) if volume < least => (least, frame) = (volume, next),
            _ => turn *= 0.5,
        }
    }
    (least, frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(centre: Vector, radius: f64) -> ShapePiece {
        ShapePiece { centre, radius }
    }

    /// A tetrapod fits into a cube with its centres in four corners of a smaller one; a row lies along its box.
    #[test]
    fn boxes_of_known_shapes_are_found_in_any_orientation() {
        let q = 0.25;
        let corners = [[q, q, q], [q, -q, -q], [-q, q, -q], [-q, -q, q]];
        let row = [[-0.5, 0.0, 0.0], [0.0; 3], [0.5, 0.0, 0.0]];
        // Eight corners of a box 3 by 2 by 1 with small spheres.
        let brick: Vec<Vector> = (0..8)
            .map(|k| [1.5 - 3.0 * f64::from(k % 2), 1.0 - 2.0 * f64::from(k / 2 % 2), 0.5 - f64::from(k / 4)])
            .collect();
        let cases: [(&[Vector], f64, Vector); 3] =
            [(&corners, 0.5, [1.5; 3]), (&row, 0.5, [2.0, 1.0, 1.0]), (&brick, 0.01, [3.02, 2.02, 1.02])];
        for (centres, radius, lengths) in cases {
            for angles in [[0.0; 3], [0.3, 0.0, 0.0], [0.4, -1.1, 0.7], [1.0, 2.0, -0.5]] {
                let frame = turned(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], &angles);
                let place = |c: &Vector| std::array::from_fn(|a| (0..3).map(|k| frame[k][a] * c[k]).sum());
                let pieces: Vec<ShapePiece> = centres.iter().map(|c| piece(place(c), radius)).collect();
                let found = least_box(&pieces);
                for k in 0..3 {
                    assert!((found[k] - lengths[k]).abs() < 1e-5 * lengths[k], "{angles:?}: {found:?}");
                }
            }
        }
    }
}
