//! Periodic images: the displacement of a grain by whole edges of the cell, and its code.

use granum_simd::{Row4, Row8, fused};

use crate::cell::Cell;
use granum_core::assembly::Matrix;
use granum_core::geometry::{apply, invert};

/// Largest number of cells by which an image may be displaced along an edge.
pub(crate) const REACH: i32 = 2;
/// Number of different image vectors.
pub(crate) const IMAGES: usize = 125;
/// Code of the image vector (0, 0, 0).
pub(crate) const NO_IMAGE: u32 = 62;

/// Code of an image vector with entries from -2 to 2.
pub(crate) fn image_code(s: [i32; 3]) -> u32 {
    (((s[0] + REACH) * 5 + (s[1] + REACH)) * 5 + (s[2] + REACH)) as u32
}

/// Image vector of a code.
#[inline(always)]
pub(crate) fn image_vector(code: u32) -> [i32; 3] {
    let c = code as i32;
    [c / 25 - REACH, (c / 5) % 5 - REACH, c % 5 - REACH]
}

/// The image vectors of all codes, m. They are computed in every step, within a kernel, where fused operations are single
/// instructions.
#[inline(always)]
pub(crate) fn image_table(cell: &Cell) -> [Row4; IMAGES] {
    let mut table = [Row4::default(); IMAGES];
    for (code, row) in table.iter_mut().enumerate() {
        let [x, y, z] = cell.image(image_vector(code as u32));
        row.0 = [x, y, z, 0.0];
    }
    table
}

/// Moves grains into the cell; returns for each the image vector that was subtracted from its position.
pub(crate) fn wrap(cell: &Cell, particles: &mut [Row8]) -> Vec<[i32; 3]> {
    let inverse = invert(&cell.edges);
    fused(
        #[inline(always)]
        || {
            let mut moves = Vec::with_capacity(particles.len());
            for row in particles {
                let (position, moved) = wrapped(cell, &inverse, row);
                row.0[..3].copy_from_slice(&position);
                moves.push(moved);
            }
            moves
        },
    )
}

/// The position of a grain moved into the cell, whose edges have this inverse, and the image vector that was subtracted from it.
#[inline(always)]
pub(crate) fn wrapped(cell: &Cell, inverse: &Matrix, row: &Row8) -> ([f64; 3], [i32; 3]) {
    let mut position = [row.0[0], row.0[1], row.0[2]];
    let [x, y, z] = apply(inverse, position);
    let moved = [x.floor() as i32, y.floor() as i32, z.floor() as i32];
    if moved != [0; 3] {
        let back = cell.image(moved);
        for a in 0..3 {
            position[a] -= back[a];
        }
    }
    (position, moved)
}
