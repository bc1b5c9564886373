//! A grid of boxes in which the neighbours of a grain are searched, and the pairs that are found.

use granum_simd::{LANES, Lanes, Row8};

use crate::assembly::{Matrix, Vector};
use crate::cell::Cell;
use crate::particle_row::ParticleRow;
use granum_core::geometry::{apply, invert};

/// A pair found by the search: indices i < j (i <= j for an image of the same grain) and image code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Near {
    pub(crate) i: u32,
    pub(crate) j: u32,
    pub(crate) image: u32,
}

/// True if two grains, the second in an image of the cell, are closer than the sum of their radii and the skin.
#[inline]
pub(crate) fn is_near(a: &Row8, b: &Row8, image: &[f64; 3], skin: f64) -> bool {
    let reach = a.radius() + b.radius() + skin;
    let d: [f64; 3] = std::array::from_fn(|k| b.0[k] + image[k] - a.0[k]);
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < reach * reach
}

/// The box of a position, from the inverse of the cell's edges.
#[inline(always)]
fn box_of(inverse: &Matrix, counts: &[usize; 3], position: Vector) -> [usize; 3] {
    let mut b = [0; 3];
    let fraction = apply(inverse, position);
    for a in 0..3 {
        b[a] = ((fraction[a] * counts[a] as f64).max(0.0) as usize).min(counts[a] - 1);
    }
    b
}

/// Grains in the order of their boxes.
pub(super) struct Grid {
    counts: [usize; 3],
    /// First member of each box, and one past the last member of the last.
    start: Vec<u32>,
    pub(super) member: Vec<u32>,
    /// x, y, z and radius of each member; entries beyond the last are out of range of all grains.
    pub(super) columns: [Vec<f64>; 4],
    /// Box of each grain.
    pub(super) of: Vec<[u32; 3]>,
}

impl Grid {
    #[inline(always)]
    pub(super) fn new(cell: &Cell, particles: &[Row8], counts: [usize; 3]) -> Grid {
        let inverse = invert(&cell.edges);
        let index = |b: [u32; 3]| (b[0] as usize * counts[1] + b[1] as usize) * counts[2] + b[2] as usize;
        let mut start = vec![0u32; counts.iter().product::<usize>() + 1];
        let mut of = Vec::with_capacity(particles.len());
        for row in particles {
            let [x, y, z, ..] = row.0;
            let b = box_of(&inverse, &counts, [x, y, z]).map(|n| n as u32);
            start[index(b) + 1] += 1;
            of.push(b);
        }
        for k in 1..start.len() {
            start[k] += start[k - 1];
        }
        let mut fill = start.clone();
        let mut member = vec![0u32; particles.len()];
        let far = || vec![f64::INFINITY; particles.len() + LANES];
        let mut columns = [far(), far(), far(), vec![0.0; particles.len() + LANES]];
        for (g, b) in of.iter().enumerate() {
            let slot = &mut fill[index(*b)];
            member[*slot as usize] = g as u32;
            for c in 0..4 {
                columns[c][*slot as usize] = particles[g].0[c];
            }
            *slot += 1;
        }
        Grid { counts, start, member, columns, of }
    }

    /// The box of a position, from the inverse of the cell's edges.
    #[inline(always)]
    pub(super) fn place(&self, inverse: &Matrix, position: Vector) -> [u32; 3] {
        box_of(inverse, &self.counts, position).map(|n| n as u32)
    }

    /// The neighbouring box index on an axis, and its displacement in cells.
    #[inline(always)]
    pub(super) fn beside(&self, axis: usize, here: u32, step: i32) -> (usize, i32) {
        let n = self.counts[axis] as i32;
        let b = here as i32 + step;
        if b < 0 {
            ((b + n) as usize, -1)
        } else if b >= n {
            ((b - n) as usize, 1)
        } else {
            (b as usize, 0)
        }
    }

    /// Ranges of boxes along the third edge that are searched for a grain, as first box, one past the last box, and
    /// displacement in cells; the second range is empty except at the ends of the cell.
    #[inline(always)]
    pub(super) fn intervals(&self, here: u32) -> [(usize, usize, i32); 2] {
        let (z, n) = (here as usize, self.counts[2]);
        let beyond = match z {
            0 => (n - 1, n, -1),
            _ if z + 1 == n => (0, 1, 1),
            _ => (0, 0, 0),
        };
        [(z.saturating_sub(1), (z + 2).min(n), 0), beyond]
    }

    /// Members of the boxes from `low` to below `high` along the third edge.
    #[inline(always)]
    pub(super) fn run(&self, x: usize, y: usize, low: usize, high: usize) -> [usize; 2] {
        let row = (x * self.counts[1] + y) * self.counts[2];
        [self.start[row + low] as usize, self.start[row + high] as usize]
    }
}

/// Loads eight numbers of a column.
#[inline(always)]
pub(super) fn load<L: Lanes>(column: &[f64], from: usize) -> L {
    let mut eight = [0.0; LANES];
    eight.copy_from_slice(&column[from..from + LANES]);
    L::load(&eight)
}
