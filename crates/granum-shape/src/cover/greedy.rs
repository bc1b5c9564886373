//! The spheres inside a body that together fill most of it: the one that fills most of what is still empty, one after the other.
//!
//! Candidates are the spheres about those voxels that are inside no larger sphere about a neighbour: the medial surface of the body. What a
//! candidate adds can only shrink while others are chosen, so that mostly only the best few are counted again. Spheres may stand out by up to
//! one voxel in this count, since all of them grow in the end.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use granum_core::assembly::Vector;

use super::grid::Grid;
use crate::mesh::Tree;
use crate::union_of_spheres::Spheres;

/// By how much of a voxel spheres may stand out, and about how many points of the body are counted, one after the other: where nothing
/// coarse remains, finer gaps count.
const STAGES: [(f64, f64); 3] = [(1.0, 1e4), (0.5, 4e4), (0.25, 4e5)];
/// A sphere inside a larger one but for this share of the distance of their centres is no candidate.
const INSIDE: f64 = 0.85;

/// How many spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestGain {
    /// Largest number of spheres.
    pub pieces: usize,
    /// Spheres become no smaller than this share of the largest one.
    pub least_radius: f64,
}

impl Default for LargestGain {
    fn default() -> Self {
        LargestGain { pieces: 20, least_radius: 0.05 }
    }
}

/// The spheres of a body as voxels; their radii are exact if its surface is known.
pub(crate) fn largest_gain(grid: &Grid, surface: Option<&Tree>, given: &LargestGain) -> Spheres {
    let least_step = grid.step.iter().copied().fold(f64::INFINITY, f64::min);
    let depths: Vec<f64> =
        grid.square_distances().into_iter().map(|square| square.sqrt() - 0.5 * least_step).collect();
    let deepest = depths.iter().copied().fold(0.0, f64::max);
    let least = given.least_radius * deepest;
    let candidates: Spheres = (0..depths.len())
        .filter(|k| depths[*k] > least && is_medial(grid, &depths, *k))
        .map(|k| (grid.centre(k), depths[k]))
        .collect();
    let mut chosen: Vec<usize> = Vec::new();
    for (out, count) in STAGES {
        choose(grid, &candidates, (out * least_step, count), given.pieces, &mut chosen);
    }
    let sphere = |k: usize| {
        let (centre, depth) = candidates[k];
        (centre, surface.map_or(depth, |tree| tree.distance(&centre)))
    };
    chosen.into_iter().map(sphere).collect()
}

/// Chooses further candidates until there are as many as wanted, or none adds anything. Spheres may stand out by a length, and about so many points are
/// counted.
fn choose(
    grid: &Grid,
    candidates: &Spheres,
    (out, count): (f64, f64),
    wanted: usize,
    chosen: &mut Vec<usize>,
) {
    if chosen.len() >= wanted {
        return;
    }
    let mut points = Points::new(grid, count);
    chosen.iter().for_each(|k| points.fill(&candidates[*k].0, candidates[*k].1 + out));
    // Of equal gains the first candidate comes first.
    let mut heap: BinaryHeap<(usize, Reverse<usize>)> =
        candidates.iter().enumerate().map(|(k, (_, r))| (points.most(r + out), Reverse(k))).collect();
    while let Some((_, Reverse(k))) = heap.pop() {
        let (centre, depth) = candidates[k];
        let gain = points.gain(&centre, depth + out);
        if heap.peek().is_some_and(|next| (gain, Reverse(k)) < *next) {
            heap.push((gain, Reverse(k)));
            continue;
        }
        if gain == 0 || chosen.len() == wanted {
            break;
        }
        points.fill(&centre, depth + out);
        chosen.push(k);
    }
}

/// True if the sphere about a voxel is inside none of those about its neighbours, as nearly as voxels tell.
fn is_medial(grid: &Grid, depths: &[f64], k: usize) -> bool {
    let [nx, ny, _] = grid.size;
    crate::directions::steps().all(|s| {
        let place = k as i64 + s[0] as i64 + nx as i64 * (s[1] as i64 + ny as i64 * s[2] as i64);
        let apart: f64 = (0..3).map(|a| s[a] * grid.step[a]).map(|d| d * d).sum();
        depths.get(place as usize).is_none_or(|depth| *depth < depths[k] + INSIDE * apart.sqrt())
    })
}

/// Evenly spread points of a body that are not yet filled.
struct Points {
    size: [usize; 3],
    step: Vector,
    first: Vector,
    empty: Vec<bool>,
}

impl Points {
    fn new(grid: &Grid, count: f64) -> Points {
        let inside = grid.inside.iter().filter(|is| **is).count() as f64;
        let every = granum_simd::cbrt(inside / count).floor().max(1.0) as usize;
        let size = grid.size.map(|n| n.div_ceil(every));
        let [nx, ny, nz] = size;
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let place = |[x, y, z]: [usize; 3]| every * (x + grid.size[0] * (y + grid.size[1] * z));
        let empty = all.map(|p| grid.inside[place(p)]).collect();
        Points { size, step: grid.step.map(|h| h * every as f64), first: grid.first, empty }
    }

    /// At least as many as there are points in a sphere.
    fn most(&self, radius: f64) -> usize {
        let half_diagonal = 0.5 * granum_core::geometry::length(&self.step);
        let reach = radius + half_diagonal;
        (4.0 / 3.0 * std::f64::consts::PI * reach * reach * reach / self.step.iter().product::<f64>())
            as usize
            + 1
    }

    /// The ranges of places of the rows of points within a sphere.
    fn rows(&self, centre: &Vector, radius: f64) -> impl Iterator<Item = Range<usize>> {
        let range = |a: usize, half: f64| {
            let at = |x: f64| ((x - self.first[a]) / self.step[a]).clamp(-1.0, self.size[a] as f64);
            let from = at(centre[a] - half).ceil().max(0.0) as usize;
            from..((at(centre[a] + half).floor() + 1.0) as usize).min(self.size[a])
        };
        range(2, radius).flat_map(move |z| {
            let dz = self.first[2] + self.step[2] * z as f64 - centre[2];
            let square = (radius * radius - dz * dz).max(0.0);
            range(1, square.sqrt()).filter_map(move |y| {
                let dy = self.first[1] + self.step[1] * y as f64 - centre[1];
                let row = self.size[0] * (y + self.size[1] * z);
                let xs = range(0, (square - dy * dy).max(0.0).sqrt());
                (xs.start < xs.end).then(|| row + xs.start..row + xs.end)
            })
        })
    }

    /// Number of empty points within a sphere.
    fn gain(&self, centre: &Vector, radius: f64) -> usize {
        self.rows(centre, radius).map(|row| self.empty[row].iter().filter(|is| **is).count()).sum()
    }

    fn fill(&mut self, centre: &Vector, radius: f64) {
        let rows: Vec<Range<usize>> = self.rows(centre, radius).collect();
        rows.into_iter().for_each(|row| self.empty[row].fill(false));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::{cube, ellipsoid};

    /// A sphere is one sphere; in a cube the largest comes first and then eight alike into the corners, and none stands out.
    #[test]
    fn the_first_spheres_are_those_that_must_be() {
        let ball = ellipsoid([1.0; 3], 5);
        let grid = Grid::of_mesh(&ball, 51);
        let found =
            largest_gain(&grid, Some(&Tree::new(&ball)), &LargestGain { pieces: 3, least_radius: 0.05 });
        assert!((found[0].1 - 1.0).abs() < 0.03, "{found:?}");
        let mesh = cube([-1.0; 3], 2.0);
        let grid = Grid::of_mesh(&mesh, 51);
        let found = largest_gain(&grid, Some(&Tree::new(&mesh)), &LargestGain::default());
        assert_eq!(found.len(), 20);
        assert!((found[0].1 - 1.0).abs() < 0.03, "{found:?}");
        for (centre, radius) in &found {
            assert!(centre.iter().all(|x| x.abs() + radius < 1.0 + 1e-9), "{centre:?} {radius}");
        }
        let corners: Vec<_> = found[1..9].iter().map(|(c, _)| c.map(|x| x > 0.0)).collect();
        assert!((0..8).all(|k| !corners[..k].contains(&corners[k])), "{found:?}");
    }

    /// The number of points within a sphere is bounded by what is said of it before they are counted.
    #[test]
    fn no_gain_is_larger_than_its_bound() {
        let grid = Grid::of_mesh(&cube([-1.0; 3], 2.0), 51);
        let points = Points::new(&grid, 1e4);
        for k in 0..40 {
            let radius = 0.02 * f64::from(k);
            let centre = [0.01 * f64::from(k % 7), -0.013 * f64::from(k % 5), 0.02];
            let inside = (0..points.empty.len()).filter(|k| points.empty[*k]).filter(|k| {
                let [nx, ny, _] = points.size;
                let place = [k % nx, k / nx % ny, k / nx / ny];
                let apart = |a: usize| points.first[a] + points.step[a] * place[a] as f64 - centre[a];
                granum_core::geometry::length(&[apart(0), apart(1), apart(2)]) <= radius
            });
            assert_eq!(points.gain(&centre, radius), inside.count(), "{radius}");
            assert!(points.gain(&centre, radius) <= points.most(radius), "{radius}");
        }
    }
}
