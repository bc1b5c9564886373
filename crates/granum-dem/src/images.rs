//! Periodic images: the displacement of a grain by whole edges of the cell, and its code.

use granum_simd::{Isa, Kernel, LANES, Lanes, Real, Row4, Row8, ScalarKernel, dispatch, fused};

use crate::cell::Cell;
use crate::particle_row::ParticleRow;
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
pub(crate) const fn image_vector(code: u32) -> [i32; 3] {
    let c = code as i32;
    [c / 25 - REACH, (c / 5) % 5 - REACH, c % 5 - REACH]
}

/// The image vectors of all codes, m, computed with the instructions of the processor in use.
pub(crate) fn image_table(isa: Isa, cell: &Cell) -> [Row4; IMAGES] {
    dispatch(isa, Images(cell))
}

struct Images<'a>(&'a Cell);

impl Kernel for Images<'_> {
    type Output = [Row4; IMAGES];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Row4; IMAGES] {
        image_table_in_lanes::<L>(self.0)
    }
}

/// The same within a kernel. The table is computed in every step.
#[inline(always)]
pub(crate) fn image_table_in_lanes<L: Lanes>(cell: &Cell) -> [Row4; IMAGES] {
    const BLOCKS: usize = IMAGES.div_ceil(LANES);
    /// The image vectors of eight codes after each other; the last block repeats the last code.
    const VECTORS: [[[f64; LANES]; 3]; BLOCKS] = {
        let mut vectors = [[[0.0; LANES]; 3]; BLOCKS];
        let mut place = 0;
        while place < BLOCKS * LANES {
            let vector = image_vector(if place < IMAGES { place as u32 } else { IMAGES as u32 - 1 });
            let mut axis = 0;
            while axis < 3 {
                vectors[place / LANES][axis][place % LANES] = vector[axis] as f64;
                axis += 1;
            }
            place += 1;
        }
        vectors
    };
    let mut table = [Row4::default(); IMAGES];
    for (eight, rows) in VECTORS.iter().zip(table.chunks_mut(LANES)) {
        let vectors = apply(&cell.edges, [L::load(&eight[0]), L::load(&eight[1]), L::load(&eight[2])]);
        let mut columns = [[0.0; LANES]; 3];
        for (vector, column) in vectors.iter().zip(&mut columns) {
            vector.store(column);
        }
        for (lane, row) in rows.iter_mut().enumerate() {
            row.0 = [columns[0][lane], columns[1][lane], columns[2][lane], 0.0];
        }
    }
    table
}

/// Moves grains into the cell; returns for each the image vector that was subtracted from its position.
pub(crate) fn wrap(cell: &Cell, particles: &mut [Row8]) -> Vec<[i32; 3]> {
    fused(Wrap { cell, particles })
}

struct Wrap<'a> {
    cell: &'a Cell,
    particles: &'a mut [Row8],
}

impl ScalarKernel for Wrap<'_> {
    type Output = Vec<[i32; 3]>;

    #[inline(always)]
    fn run<R: Real>(self) -> Vec<[i32; 3]> {
        let inverse = invert(&self.cell.edges);
        let mut moves = Vec::with_capacity(self.particles.len());
        for row in self.particles {
            let (position, moved) = wrapped::<R>(self.cell, &inverse, row);
            row.0[..3].copy_from_slice(&position);
            moves.push(moved);
        }
        moves
    }
}

/// The position of a grain moved into the cell, whose edges have this inverse, and the image vector that was subtracted from it.
#[inline(always)]
pub(crate) fn wrapped<R: Real>(cell: &Cell, inverse: &Matrix, row: &Row8) -> ([f64; 3], [i32; 3]) {
    let mut position = row.position();
    let [x, y, z] = times::<R>(inverse, position);
    let moved = [x.floor() as i32, y.floor() as i32, z.floor() as i32];
    if moved != [0; 3] {
        let back = times::<R>(&cell.edges, [f64::from(moved[0]), f64::from(moved[1]), f64::from(moved[2])]);
        for a in 0..3 {
            position[a] -= back[a];
        }
    }
    (position, moved)
}

/// Matrix times vector, with the fused operations of `R`.
#[inline(always)]
fn times<R: Real>(matrix: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = apply(matrix, [R::splat(x), R::splat(y), R::splat(z)]);
    [x.reduce_add(), y.reduce_add(), z.reduce_add()]
}
