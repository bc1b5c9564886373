//! The search among grains of very different sizes, with a grid of its own for each class of sizes.
//!
//! In one grid the boxes would be as wide as two of the largest grains, and contain hundreds of the smallest. Here each grain belongs to
//! a level, whose grains differ in size by less than a factor of two, and each level has a grid with boxes for its own largest
//! grain. Neighbours of a grain are searched in the grids of its own level and of all coarser ones, whose boxes contain about one grain
//! each.
//! The pairs are the same, bit by bit, as those of one grid.

use granum_simd::{Isa, Kernel, LANES, Lanes, Mask, Row8, dispatch};

use granum_core::geometry::invert;

use super::grid::{Grid, Near, is_near, load};
use crate::assembly::Matrix;
use crate::cell::Cell;
use crate::images::{image_code, image_table_in_lanes};
use crate::particle_row::ParticleRow;

/// Largest ratio of radii for which one grid is used.
pub(super) const ONE_GRID: f64 = 2.5;
/// A slight excess of the range in the first test, which rounds otherwise than the second where two grains change roles.
const MARGIN: f64 = 1.0 + 1e-9;

/// Grains of similar size.
struct Level {
    /// Their indices.
    grains: Vec<u32>,
    grid: Grid,
}

/// All pairs within the skin, sorted; `None` if a grid would have fewer than three boxes along an edge.
pub(super) fn find(isa: Isa, cell: &Cell, particles: &[Row8], skin: f64) -> Option<Vec<Near>> {
    let levels = levels(cell, particles, skin)?;
    let inverse = invert(&cell.edges);
    Some(dispatch(isa, LevelSearch { cell, inverse, particles, skin, levels }))
}

fn levels(cell: &Cell, particles: &[Row8], skin: f64) -> Option<Vec<Level>> {
    let smallest = particles.iter().fold(f64::INFINITY, |m, row| m.min(row.radius()));
    let mut members: Vec<Vec<u32>> = Vec::new();
    for (g, row) in particles.iter().enumerate() {
        let mut level = 0;
        let mut bound = 2.0 * smallest;
        while row.radius() > bound {
            level += 1;
            bound *= 2.0;
        }
        if members.len() <= level {
            members.resize(level + 1, Vec::new());
        }
        members[level].push(g as u32);
    }
    let grids = members.into_iter().filter(|grains| !grains.is_empty()).map(|grains| {
        let own: Vec<Row8> = grains.iter().map(|&g| particles[g as usize]).collect();
        let largest = own.iter().fold(0.0f64, |m, row| m.max(row.radius()));
        let limit = libm::cbrt(own.len() as f64).ceil() as usize + 2;
        let counts = cell.heights().map(|h| ((h / (2.0 * largest + skin)).floor() as usize).min(limit));
        counts.iter().all(|&n| n >= 3).then(|| Level { grid: Grid::new(cell, &own, counts), grains })
    });
    grids.collect()
}

struct LevelSearch<'a> {
    cell: &'a Cell,
    inverse: Matrix,
    particles: &'a [Row8],
    skin: f64,
    levels: Vec<Level>,
}

impl Kernel for LevelSearch<'_> {
    type Output = Vec<Near>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<Near> {
        let images = image_table_in_lanes::<L>(self.cell);
        let mut found = Vec::with_capacity(self.particles.len() * 4);
        for (finer, level) in self.levels.iter().enumerate() {
            for &i in &level.grains {
                for coarser in &self.levels[finer..] {
                    self.collect::<L>(i, coarser, std::ptr::eq(level, coarser), &images, &mut found);
                }
            }
        }
        found.sort_unstable();
        found
    }
}

impl LevelSearch<'_> {
    /// Appends the pairs of a grain with those of a level; each once where the level is its own.
    #[inline(always)]
    fn collect<L: Lanes>(
        &self,
        i: u32,
        level: &Level,
        own: bool,
        images: &[granum_simd::Row4],
        found: &mut Vec<Near>,
    ) {
        let grid = &level.grid;
        let row = &self.particles[i as usize];
        let [x, y, z, radius, ..] = row.0;
        let position = [L::splat(x), L::splat(y), L::splat(z)];
        let here = grid.place(&self.inverse, [x, y, z]);
        for step in 0..9 {
            let (bx, sx) = grid.beside(0, here[0], step / 3 - 1);
            let (by, sy) = grid.beside(1, here[1], step % 3 - 1);
            for (low, high, sz) in grid.intervals(here[2]) {
                let shift = [sx, sy, sz];
                let image = &images[image_code(shift) as usize].0;
                let [start, end] = grid.run(bx, by, low, high);
                for from in (start..end).step_by(LANES) {
                    let mut square = L::zero();
                    for k in 0..3 {
                        let d = load::<L>(&grid.columns[k], from) + L::splat(image[k]) - position[k];
                        square = square + d * d;
                    }
                    let reach =
                        (L::splat(radius + self.skin) + load::<L>(&grid.columns[3], from)) * L::splat(MARGIN);
                    let mut near = square.lt(reach * reach).bits();
                    if end - from < LANES {
                        near &= (1 << (end - from)) - 1;
                    }
                    while near != 0 {
                        let j = level.grains[grid.member[from + near.trailing_zeros() as usize] as usize];
                        near &= near - 1;
                        if !(own && j <= i) {
                            self.push(i, j, shift, images, found);
                        }
                    }
                }
            }
        }
    }

    /// Appends a pair, of which the grain with the lower index comes first, if it passes the test of one grid.
    #[inline(always)]
    fn push(&self, i: u32, j: u32, shift: [i32; 3], images: &[granum_simd::Row4], found: &mut Vec<Near>) {
        let (first, second, shift) = if i < j { (i, j, shift) } else { (j, i, shift.map(|s| -s)) };
        let code = image_code(shift);
        let [x, y, z, _] = images[code as usize].0;
        let [a, b] = [first, second].map(|g| &self.particles[g as usize]);
        if is_near(a, b, &[x, y, z], self.skin) {
            found.push(Near { i: first, j: second, image: code });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pairs::tests::grains;
    use crate::search::{GridSearch, find_all_images};

    /// Sizes from 1 to 1/16, in a cell that is not rectangular, on every instruction set.
    #[test]
    fn levels_find_what_one_grid_finds() {
        for (x, count) in [(13.0, 900), (5.0, 400)] {
            let cell = Cell { edges: [[x, 1.0, -0.5], [0.0, 9.0, 0.3], [0.0, 0.0, 11.0]] };
            let mut particles = grains(count, &cell, 0.7);
            for (g, row) in particles.iter_mut().enumerate() {
                row.0[3] /= [16.0, 8.0, 5.0, 3.0, 2.0, 16.0, 1.0][g % 7];
            }
            let mut expected = find_all_images(&cell, &particles, 0.1, 1.6);
            expected.sort_unstable();
            assert!(expected.len() > count / 4, "{}", expected.len());
            let counts = cell.heights().map(|h| (h / 1.6).floor() as usize);
            for isa in Isa::ALL {
                let found = find(isa, &cell, &particles, 0.1).unwrap();
                assert!(found == expected, "{x} {}: {} {}", isa.name(), found.len(), expected.len());
                if counts.iter().all(|&n| n >= 3) {
                    let one =
                        dispatch(isa, GridSearch { cell: &cell, particles: &particles, skin: 0.1, counts });
                    assert!(found == one);
                }
            }
        }
    }
}
