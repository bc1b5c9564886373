//! Grossly overlapping grains, which no packing has.

use granum_core::geometry::{Matrix, Vector};

use super::near::{NearGrains, Neighbour};
use super::packed_body::PackedBody;
use super::packed_grain::PackedGrain;
use crate::error::{Result, in_file};

/// Overlap as a fraction of the smaller diameter above which a packing is rejected.
pub const GROSS_OVERLAP: f64 = 0.05;

/// Rejects a packing with the first grain that overlaps another grossly; `grains` contains the grains with their line
/// numbers. Pieces of one grain overlap as they please.
pub(super) fn check(
    file: &str,
    edges: &Matrix,
    grains: &[(PackedGrain, usize)],
    bodies: &[PackedBody],
) -> Result<()> {
    let spheres = spheres(grains, bodies);
    let positions: Vec<Vector> = spheres.iter().map(|sphere| sphere.position).collect();
    let radii: Vec<f64> = spheres.iter().map(|sphere| sphere.radius).collect();
    let near = NearGrains::new(Some(edges), &positions, &radii);
    for at in 0..spheres.len() {
        let mut gross: Option<Neighbour> = None;
        near.around(at, |other| {
            let smaller_diameter = 2.0 * radii[at].min(radii[other.grain]);
            let apart = spheres[at].grain != spheres[other.grain].grain;
            gross = (apart && other.overlap > GROSS_OVERLAP * smaller_diameter).then_some(other);
            gross.is_none()
        });
        let Some(Neighbour { grain: other, overlap, .. }) = gross else { continue };
        let ((grain, line), (second, second_line)) =
            (&grains[spheres[at].grain], &grains[spheres[other].grain]);
        let other_line = if *second_line == 0 { String::new() } else { format!(" (line {second_line})") };
        let message = format!(
            "grain {} overlaps grain {}{other_line} by {overlap:.3e} m, {:.1} % of the smaller diameter",
            grain.id,
            second.id,
            50.0 * overlap / radii[at].min(radii[other])
        );
        let help =
            format!("at most {} % is accepted in a packing; are the radii right?", 100.0 * GROSS_OVERLAP);
        return Err(in_file(file, *line, message, &help));
    }
    Ok(())
}

/// A sphere of the grain at a place among the grains.
struct SphereOfGrain {
    grain: usize,
    position: Vector,
    radius: f64,
}

/// The spheres of all grains: the grain itself, or its pieces.
fn spheres(grains: &[(PackedGrain, usize)], bodies: &[PackedBody]) -> Vec<SphereOfGrain> {
    let mut bodies = bodies.iter().peekable();
    let mut spheres = Vec::with_capacity(grains.len());
    for (at, (grain, _)) in grains.iter().enumerate() {
        match bodies.next_if(|body| body.grain == at) {
            None => spheres.push(SphereOfGrain { grain: at, position: grain.position, radius: grain.radius }),
            Some(body) => spheres.extend(body.pieces.iter().map(|piece| SphereOfGrain {
                grain: at,
                position: std::array::from_fn(|a| grain.position[a] + piece.arm[a]),
                radius: piece.radius,
            })),
        }
    }
    spheres
}
