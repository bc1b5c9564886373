//! Neighbour search: all pairs of grains closer than `R_i + R_j + skin`.
//!
//! The grains are sorted into boxes that are at least as wide as the interaction range of a pair. Three successive boxes
//! along the third edge are contiguous in memory, so that a grain is compared with nine ranges of other grains, eight grains
//! at a time. Grains of very different sizes have several grids ([`levels`]).

mod grid;
mod levels;

use granum_simd::{Isa, Kernel, LANES, Lanes, Mask, Row8, dispatch};

use crate::cell::Cell;
use crate::images::{REACH, image_code, image_table_in_lanes};
use crate::particle_row::ParticleRow;

use self::grid::{Grid, load};
pub(crate) use self::grid::{Near, is_near};

/// All pairs within the skin, sorted. `particles` holds the grains only, inside the cell.
pub(crate) fn find(isa: Isa, cell: &Cell, particles: &[Row8], skin: f64) -> Vec<Near> {
    let largest = particles.iter().fold(0.0f64, |m, row| m.max(row.radius()));
    let cutoff = 2.0 * largest + skin;
    let limit = libm::cbrt(particles.len() as f64).ceil() as usize + 1;
    let counts = cell.heights().map(|h| ((h / cutoff).floor() as usize).clamp(1, limit.max(1)));
    if counts.iter().all(|&n| n >= 3) {
        let smallest = particles.iter().fold(f64::INFINITY, |m, row| m.min(row.radius()));
        let found = (largest > levels::ONE_GRID * smallest).then(|| levels::find(isa, cell, particles, skin));
        if let Some(found) = found.flatten() {
            return found;
        }
        return dispatch(isa, GridSearch { cell, particles, skin, counts });
    }
    let mut found = find_all_images(cell, particles, skin, cutoff);
    found.sort_unstable();
    found
}

/// The search in a grid of at least three boxes along every edge.
struct GridSearch<'a> {
    cell: &'a Cell,
    particles: &'a [Row8],
    skin: f64,
    counts: [usize; 3],
}

impl Kernel for GridSearch<'_> {
    type Output = Vec<Near>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<Near> {
        let grid = Grid::new(self.cell, self.particles, self.counts);
        let images = image_table_in_lanes::<L>(self.cell);
        let mut found = Vec::with_capacity(self.particles.len() * 4);
        for (i, row) in self.particles.iter().enumerate() {
            let from = found.len();
            let seeker = Seeker::<L>::new(i as u32, row, self.skin);
            let here = grid.of[i];
            for step in 0..9 {
                let (x, sx) = grid.beside(0, here[0], step / 3 - 1);
                let (y, sy) = grid.beside(1, here[1], step % 3 - 1);
                for (low, high, sz) in grid.intervals(here[2]) {
                    let code = image_code([sx, sy, sz]);
                    seeker.search_box(
                        &grid,
                        grid.run(x, y, low, high),
                        code,
                        &images[code as usize].0,
                        &mut found,
                    );
                }
            }
            found[from..].sort_unstable();
        }
        found
    }
}

/// A grain whose neighbours with a higher index are searched.
struct Seeker<L> {
    i: u32,
    position: [L; 3],
    radius: L,
    skin: L,
}

impl<L: Lanes> Seeker<L> {
    #[inline(always)]
    fn new(i: u32, row: &Row8, skin: f64) -> Self {
        let [x, y, z, radius, ..] = row.0;
        Seeker {
            i,
            position: [L::splat(x), L::splat(y), L::splat(z)],
            radius: L::splat(radius),
            skin: L::splat(skin),
        }
    }

    /// Appends the members of a range that are close enough.
    #[inline(always)]
    fn search_box(&self, grid: &Grid, range: [usize; 2], code: u32, image: &[f64; 4], found: &mut Vec<Near>) {
        let [start, end] = range;
        for from in (start..end).step_by(LANES) {
            let mut square = L::zero();
            for k in 0..3 {
                let d = load::<L>(&grid.columns[k], from) + L::splat(image[k]) - self.position[k];
                square = square + d * d;
            }
            let reach = self.radius + load::<L>(&grid.columns[3], from) + self.skin;
            let mut near = square.lt(reach * reach).bits();
            if end - from < LANES {
                near &= (1 << (end - from)) - 1;
            }
            while near != 0 {
                let j = grid.member[from + near.trailing_zeros() as usize];
                if j > self.i {
                    found.push(Near { i: self.i, j, image: code });
                }
                near &= near - 1;
            }
        }
    }
}

/// The search for cells only a few grains wide: every pair with every image within range, images of the same grain included.
fn find_all_images(cell: &Cell, particles: &[Row8], skin: f64, cutoff: f64) -> Vec<Near> {
    let heights = cell.heights();
    let reach: [i32; 3] = heights.map(|h| ((cutoff / h).ceil() as i32).clamp(1, REACH));
    let mut images = Vec::new();
    for a in -reach[0]..=reach[0] {
        for b in -reach[1]..=reach[1] {
            for c in -reach[2]..=reach[2] {
                images.push(([a, b, c], cell.image([a, b, c])));
            }
        }
    }
    let mut found = Vec::new();
    for (i, row) in particles.iter().enumerate() {
        for (j, other) in particles.iter().enumerate().skip(i) {
            for (s, image) in &images {
                if (j > i || *s > [0; 3]) && is_near(row, other, image, skin) {
                    found.push(Near { i: i as u32, j: j as u32, image: image_code(*s) });
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pairs::tests::grains;

    fn slow(cell: &Cell, particles: &[Row8], skin: f64) -> Vec<Near> {
        let mut found = find_all_images(cell, particles, skin, 1.5);
        found.sort_unstable();
        found
    }

    /// Down to three boxes along an edge, on every instruction set.
    #[test]
    fn the_grid_finds_what_all_images_find() {
        for (x, least) in [(10.0, 100), (4.6, 300)] {
            let cell = Cell { edges: [[x, 1.0, -0.5], [0.0, 9.0, 0.3], [0.0, 0.0, 11.0]] };
            let mut particles = grains(300, &cell, 0.7);
            for (g, row) in particles.iter_mut().enumerate() {
                row.0[3] -= 0.3 * (g % 7) as f64 / 7.0;
            }
            let expected = slow(&cell, &particles, 0.1);
            assert!(expected.len() > least);
            for isa in Isa::ALL {
                assert!(find(isa, &cell, &particles, 0.1) == expected, "{x} {}", isa.name());
            }
        }
    }

    #[test]
    fn small_cells_see_images_of_themselves() {
        let cell = Cell::cuboid([1.0; 3]);
        let particles = [Row8([0.5, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0, 1.0])];
        assert_eq!(find(Isa::detect(), &cell, &particles, 1e-3).len(), 3);
    }
}
