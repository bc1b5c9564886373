//! Grossly overlapping grains, which no packing has.

use granum_core::geometry::{Matrix, Vector};

use super::near::{NearGrains, Neighbour};
use super::packed_grain::PackedGrain;
use crate::error::{Result, in_file};

/// Overlap as a fraction of the smaller diameter above which a packing is rejected.
pub const GROSS_OVERLAP: f64 = 0.05;

/// Rejects a packing with the first grain that overlaps another grossly; `grains` contains the grains with their line
/// numbers.
pub(super) fn check(file: &str, edges: &Matrix, grains: &[(PackedGrain, usize)]) -> Result<()> {
    let positions: Vec<Vector> = grains.iter().map(|(grain, _)| grain.position).collect();
    let radii: Vec<f64> = grains.iter().map(|(grain, _)| grain.radius).collect();
    let near = NearGrains::new(Some(edges), &positions, &radii);
    for at in 0..grains.len() {
        let mut gross: Option<Neighbour> = None;
        near.around(at, |other| {
            let smaller_diameter = 2.0 * radii[at].min(radii[other.grain]);
            gross = (other.overlap > GROSS_OVERLAP * smaller_diameter).then_some(other);
            gross.is_none()
        });
        let Some(Neighbour { grain: other, overlap, .. }) = gross else { continue };
        let ((grain, line), (second, second_line)) = (&grains[at], &grains[other]);
        let other_line = if *second_line == 0 { String::new() } else { format!(" (line {second_line})") };
        let message = format!(
            "grain {} overlaps grain {}{other_line} by {overlap:.3e} m, {:.1} % of the smaller diameter",
            grain.id,
            second.id,
            50.0 * overlap / grain.radius.min(second.radius)
        );
        let help =
            format!("at most {} % is accepted in a packing; are the radii right?", 100.0 * GROSS_OVERLAP);
        return Err(in_file(file, *line, message, &help));
    }
    Ok(())
}
