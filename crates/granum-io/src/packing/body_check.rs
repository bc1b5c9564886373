//! What is impossible about the grains of a packing that have several pieces.

use granum_core::Cell;
use granum_core::assembly::Matrix;

use super::lattice::reduced;
use super::packed_body::PackedBody;
use super::packed_grain::PackedGrain;
use crate::error::{Result, in_file};

/// Largest difference of the square of the length of a quaternion from 1.
const UNIT: f64 = 1e-9;

/// Refuses bodies with impossible numbers and bodies larger than half the cell; `grains` contains the grains with their line numbers.
pub(super) fn check(
    file: &str,
    cell: &Matrix,
    grains: &[(PackedGrain, usize)],
    bodies: &[PackedBody],
) -> Result<()> {
    let height = Cell { edges: reduced(cell) }.heights().into_iter().fold(f64::INFINITY, f64::min);
    for body in bodies {
        let Some((grain, line)) = grains.get(body.grain) else { continue };
        let wrong = |message: String, help: &str| {
            Err(in_file(file, *line, format!("body {}: {message}", grain.id), help))
        };
        let length: f64 = body.orientation.iter().map(|x| x * x).sum();
        if (length - 1.0).abs().partial_cmp(&UNIT) != Some(std::cmp::Ordering::Less) {
            let message = format!("its orientation {:?} has not the length 1", body.orientation);
            return wrong(message, "an orientation is a quaternion w, x, y, z; no rotation is 1, 0, 0, 0");
        }
        let inertia = body.inertia_over_mass;
        if inertia.iter().any(|moment| !(*moment > 0.0 && moment.is_finite())) {
            let message = format!("its moments of inertia over its mass are {inertia:?} m2");
            return wrong(message, "they must be positive");
        }
        let finite = |x: &f64| x.is_finite();
        if body.pieces.is_empty()
            || body.pieces.iter().any(|piece| !(piece.radius > 0.0 && piece.arm.iter().all(finite)))
        {
            return wrong(
                "its pieces must have finite places and positive radii".into(),
                "a body has at least one piece",
            );
        }
        let length = 2.0 * body.reach();
        if length > 0.5 * height {
            let message = format!(
                "it is {length:e} m long about its centre, more than half the width of the cell, {height:e} m"
            );
            let help =
                "a body must be at most half as large as the cell, or two images of it could touch one grain";
            return wrong(message, help);
        }
    }
    Ok(())
}
