//! Search for grains that are near each other, in any cell or none, and for any mixture of sizes.
//!
//! Grains are sorted into levels by octave of radius, and each level into bins no narrower than its largest diameter. For
//! each grain, its own level and those of smaller grains are searched, so that one large grain among many small ones costs
//! little. The cell is first [reduced](super::lattice::reduced), so that a skewed one is searched like the box that it repeats.

use granum_core::Cell;
use granum_core::geometry::{Matrix, Vector, apply, dot, invert};

use super::lattice::reduced;

/// Largest number of bins along an edge.
const MOST_BINS: i64 = 1 << 20;

/// A grain that is near another, or an image of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Neighbour {
    /// Its number in the list of grains, from 0.
    pub(crate) grain: usize,
    /// Vector from the centre of the other to its own, m.
    pub(crate) branch: Vector,
    /// Sum of the radii less the distance of the centres, m: negative if there is a gap.
    pub(crate) overlap: f64,
}

/// Grains of one octave of radii.
struct Level {
    largest_radius: f64,
    bins: [i64; 3],
    /// Bin and grain, sorted.
    entries: Vec<(u64, u32)>,
}

/// Grains sorted for the search.
pub(crate) struct NearGrains {
    edges: Matrix,
    heights: Vector,
    radii: Vec<f64>,
    /// Positions in units of the edges, in [0, 1).
    places: Vec<Vector>,
    level_of: Vec<u32>,
    levels: Vec<Level>,
}

impl NearGrains {
    /// Grains with these positions and radii, m, in a cell with these edges, or in none.
    pub(crate) fn new(cell: Option<&Matrix>, positions: &[Vector], radii: &[f64]) -> NearGrains {
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let edges = cell.map_or_else(|| around(positions, largest), reduced);
        let inverse = invert(&edges);
        // The corner of the cell does not matter: differences and wrapped positions are the same.
        let wrapped = |position: &Vector| apply(&inverse, *position).map(|s| s - s.floor());
        let octaves: Vec<u32> = radii.iter().map(|radius| libm::log2(largest / radius) as u32).collect();
        let mut present = octaves.clone();
        present.sort_unstable();
        present.dedup();
        let level_of: Vec<u32> =
            octaves.iter().map(|octave| present.partition_point(|other| other < octave) as u32).collect();
        let mut near = NearGrains {
            edges,
            heights: Cell { edges }.heights(),
            radii: radii.to_vec(),
            places: positions.iter().map(wrapped).collect(),
            level_of,
            levels: vec![],
        };
        near.levels = (0..present.len() as u32).map(|level| near.fill(level)).collect();
        near
    }

    fn fill(&self, level: u32) -> Level {
        let members: Vec<usize> = (0..self.radii.len()).filter(|at| self.level_of[*at] == level).collect();
        let largest_radius = members.iter().map(|at| self.radii[*at]).fold(0.0, f64::max);
        let bins = self.heights.map(|height| ((height / (2.0 * largest_radius)) as i64).clamp(1, MOST_BINS));
        let bin = |at: usize| {
            std::array::from_fn(|k| ((self.places[at][k] * bins[k] as f64) as i64).min(bins[k] - 1))
        };
        let mut entries: Vec<(u64, u32)> = members.iter().map(|at| (key(bin(*at)), *at as u32)).collect();
        entries.sort_unstable();
        Level { largest_radius, bins, entries }
    }

    /// Calls `visit` with grains of the level of grain `at` and of levels of smaller grains that may touch it, among them all that do,
    /// until it returns false.
    pub(crate) fn around(&self, at: usize, mut visit: impl FnMut(Neighbour) -> bool) {
        let own = self.level_of[at] as usize;
        for level in &self.levels[own..] {
            let reach = self.radii[at] + level.largest_radius;
            let range: [(i64, i64); 3] = std::array::from_fn(|k| {
                let (place, half, bins) = (self.places[at][k], reach / self.heights[k], level.bins[k] as f64);
                (((place - half) * bins).floor() as i64, ((place + half) * bins).floor() as i64)
            });
            let boxes: i64 = range.iter().map(|(low, high)| high - low + 1).product();
            let goes_on = if boxes as usize > 27 + level.entries.len() {
                self.among_all(at, level, &mut visit)
            } else {
                self.among_bins(at, level, range, &mut visit)
            };
            if !goes_on {
                return;
            }
        }
    }

    /// Every pair of grains whose overlap is larger than `least`, m, each once: the number of the first, and its neighbour with a
    /// larger number. Two grains that touch through several images of the cell are several pairs.
    pub(crate) fn touching(&self, least: f64) -> Vec<(usize, Neighbour)> {
        let mut pairs: Vec<(usize, Neighbour)> = Vec::new();
        for at in 0..self.radii.len() {
            self.around(at, |near| {
                let is_first = self.level_of[near.grain] != self.level_of[at] || at < near.grain;
                if near.overlap > least && is_first {
                    pairs.push(ordered(at, near));
                }
                true
            });
        }
        let image = |(at, near): &(usize, Neighbour)| (*at, near.grain, near.branch.map(f64::to_bits));
        pairs.sort_unstable_by_key(image);
        pairs
    }

    fn among_bins(
        &self,
        at: usize,
        level: &Level,
        [x, y, z]: [(i64, i64); 3],
        visit: &mut impl FnMut(Neighbour) -> bool,
    ) -> bool {
        for i in x.0..=x.1 {
            for j in y.0..=y.1 {
                for k in z.0..=z.1 {
                    let bin = [i, j, k];
                    let image = std::array::from_fn(|a| bin[a].div_euclid(level.bins[a]) as f64);
                    let wrapped = key(std::array::from_fn(|a| bin[a].rem_euclid(level.bins[a])));
                    let first = level.entries.partition_point(|entry| entry.0 < wrapped);
                    let mut members = level.entries[first..].iter().take_while(|entry| entry.0 == wrapped);
                    if !members.all(|entry| self.visit(at, entry.1 as usize, image, visit)) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Searches all grains of the level and their nearest images, for the case that the bins within range outnumber the
    /// grains.
    fn among_all(&self, at: usize, level: &Level, visit: &mut impl FnMut(Neighbour) -> bool) -> bool {
        level.entries.iter().all(|(_, other)| {
            (0..27).all(|n| {
                let image = [n % 3, n / 3 % 3, n / 9].map(|a| f64::from(a) - 1.0);
                self.visit(at, *other as usize, image, visit)
            })
        })
    }

    fn visit(
        &self,
        at: usize,
        other: usize,
        image: Vector,
        visit: &mut impl FnMut(Neighbour) -> bool,
    ) -> bool {
        if at == other {
            return true;
        }
        let apart: Vector = std::array::from_fn(|a| self.places[other][a] + image[a] - self.places[at][a]);
        let branch = apply(&self.edges, apart);
        let overlap = self.radii[at] + self.radii[other] - dot(&branch, &branch).sqrt();
        visit(Neighbour { grain: other, branch, overlap })
    }
}

/// A pair with the smaller number first.
fn ordered(at: usize, near: Neighbour) -> (usize, Neighbour) {
    if at < near.grain {
        return (at, near);
    }
    (near.grain, Neighbour { grain: at, branch: near.branch.map(|x| -x), ..near })
}

/// A cuboid around grains that is so large that none of them is near an image of another.
fn around(positions: &[Vector], largest_radius: f64) -> Matrix {
    let mut edges = [[0.0; 3]; 3];
    for (axis, row) in edges.iter_mut().enumerate() {
        let places = positions.iter().map(|position| position[axis]);
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        row[axis] = (high - low).max(0.0) + 4.0 * largest_radius;
    }
    edges
}

/// A single number for a bin, with 21 bits for each axis.
fn key(bin: [i64; 3]) -> u64 {
    bin.iter().fold(0, |key, index| key << 21 | *index as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All pairs by trying every image of a cell that is wide enough.
    fn by_trying(cell: Option<&Matrix>, positions: &[Vector], radii: &[f64]) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for i in 0..positions.len() {
            for j in i + 1..positions.len() {
                let images = if cell.is_some() { -3..=3 } else { 0..=0 };
                for n in images.clone().flat_map(|x| {
                    let z = images.clone();
                    images.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z].map(f64::from)))
                }) {
                    let shift = cell.map_or([0.0; 3], |edges| apply(edges, n));
                    let apart: Vector = std::array::from_fn(|a| positions[j][a] - positions[i][a] + shift[a]);
                    if dot(&apart, &apart).sqrt() < radii[i] + radii[j] {
                        pairs.push((i, j));
                    }
                }
            }
        }
        pairs
    }

    proptest! {
        #[test]
        fn every_pair_that_touches_is_found_once(
            grains in prop::collection::vec(([0.0..1.0f64, 0.0..1.0, 0.0..1.0], -2.0..0.0f64), 2..40),
            skew in [-0.9..0.9f64, -0.9..0.9, -0.9..0.9],
            periodic: bool,
        ) {
            let edges = [[1.0, skew[0], skew[1]], [0.0, 1.1, skew[2]], [0.0, 0.0, 0.9]];
            let cell = periodic.then_some(&edges);
            let positions: Vec<Vector> = grains.iter().map(|(place, _)| apply(&edges, *place)).collect();
            let radii: Vec<f64> = grains.iter().map(|(_, size)| 0.15 * 10f64.powf(*size)).collect();
            let near = NearGrains::new(cell, &positions, &radii);
            let mut pairs: Vec<(usize, usize)> =
                near.touching(0.0).into_iter().map(|(at, near)| (at, near.grain)).collect();
            let mut wanted = by_trying(cell, &positions, &radii);
            pairs.sort_unstable();
            wanted.sort_unstable();
            prop_assert_eq!(pairs, wanted);
        }
    }

    #[test]
    fn a_pair_has_its_branch_and_overlap_across_a_skewed_boundary() {
        // The lattice of a cube of edge 4, by a cell that is sheared by ten edges.
        let edges = [[4.0, 40.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let near = NearGrains::new(Some(&edges), &[[0.2, 1.0, 1.0], [3.3, 1.0, 1.0]], &[0.5, 0.5]);
        let [(0, pair)] = near.touching(0.0)[..] else { panic!() };
        assert_eq!(pair.grain, 1);
        assert!((pair.branch[0] + 0.9).abs() < 1e-12 && (pair.overlap - 0.1).abs() < 1e-12, "{pair:?}");
    }
}
