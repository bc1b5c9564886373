//! The Euclidean map (Angelidakis et al. 2021, CLUMP): the largest sphere that fits, without its core of `1 - overlap` of its radius the next
//! largest, and so on.
//!
//! The distance of a point of what remains from its surface is the least of its distance from the surface of the body and of those from the
//! cores, so that the transform of the voxels is needed once.

use granum_core::assembly::Vector;
use granum_core::geometry::length;

use super::grid::Grid;
use crate::directions::directions;
use crate::mesh::Tree;
use crate::union_of_spheres::Spheres;

/// Last step of the refinement of a centre over the spacing of voxels.
const LAST_STEP: f64 = 1e-2;

/// Number of directions that are tried at once, and how often in vain before the step is halved.
const TRIES: usize = 26;
const FAILURES: usize = 4;

/// How many spheres, and how far they may overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EuclideanMap {
    /// Largest number of spheres.
    pub pieces: usize,
    /// Share of its radius up to which a sphere may be entered by later ones, from 0 to below 1.
    pub overlap: f64,
    /// Spheres become no smaller than this share of the largest one.
    pub least_radius: f64,
}

impl Default for EuclideanMap {
    fn default() -> Self {
        EuclideanMap { pieces: 20, overlap: 0.7, least_radius: 0.05 }
    }
}

/// The spheres of a body as voxels; their centres and radii are refined with its surface if that is known.
pub(crate) fn euclidean_map(grid: &Grid, surface: Option<&Tree>, given: &EuclideanMap) -> Spheres {
    let least_step = grid.step.iter().copied().fold(f64::INFINITY, f64::min);
    // The surface is half a voxel before the centre of an empty one.
    let mut depths: Vec<f64> =
        grid.square_distances().into_iter().map(|square| square.sqrt() - 0.5 * least_step).collect();
    let mut spheres: Spheres = Vec::new();
    let mut cores: Spheres = Vec::new();
    while spheres.len() < given.pieces {
        let deepest = (0..depths.len()).fold(0, |best, k| if depths[k] > depths[best] { k } else { best });
        let (centre, radius) = match surface {
            None => (grid.centre(deepest), depths[deepest]),
            Some(tree) => refined(tree, &cores, grid.centre(deepest), least_step),
        };
        let least = spheres.first().map_or(0.0, |(_, largest)| given.least_radius * largest);
        if radius <= least {
            break;
        }
        spheres.push((centre, radius));
        let core = (1.0 - given.overlap) * radius;
        cores.push((centre, core));
        dig(&mut depths, grid, &centre, core);
    }
    spheres
}

/// Lowers the depths to the distances from a core.
fn dig(depths: &mut [f64], grid: &Grid, centre: &Vector, core: f64) {
    let [nx, ny, _] = grid.size;
    for (row, depths) in depths.chunks_exact_mut(nx).enumerate() {
        let y = grid.first[1] + grid.step[1] * (row % ny) as f64 - centre[1];
        let z = grid.first[2] + grid.step[2] * (row / ny) as f64 - centre[2];
        let across = y * y + z * z;
        for (k, depth) in depths.iter_mut().enumerate() {
            let x = grid.first[0] + grid.step[0] * k as f64 - centre[0];
            let square = x * x + across;
            if *depth > 0.0 && square < (*depth + core) * (*depth + core) {
                *depth = square.sqrt() - core;
            }
        }
    }
}

/// The deepest point near a voxel, and its depth.
fn refined(tree: &Tree, cores: &[(Vector, f64)], start: Vector, voxel: f64) -> (Vector, f64) {
    let depth = |x: &Vector| {
        let from = |(centre, core): &(Vector, f64)| length(&std::array::from_fn(|a| x[a] - centre[a])) - core;
        cores.iter().map(from).fold(tree.distance(x), f64::min)
    };
    // Ever other directions: where faces and cores meet only few of them lead deeper.
    let units = &directions(3).units;
    let (mut place, mut best, mut step) = (start, depth(&start), 0.5 * voxel);
    let (mut turn, mut failed) = (0, 0);
    while step > LAST_STEP * voxel {
        let tries = (0..TRIES).map(|k| &units[(k * units.len() / TRIES + turn) % units.len()]);
        let places = tries.map(|u| -> Vector { std::array::from_fn(|a| place[a] + step * u[a]) });
        let next = places.map(|x| (depth(&x), x)).fold((best, place), |a, b| if b.0 > a.0 { b } else { a });
        turn += 7;
        if next.0 > best + 1e-6 * voxel {
            (best, place, failed) = (next.0, next.1, 0);
        } else if failed < FAILURES {
            failed += 1;
        } else {
            (step, failed) = (0.5 * step, 0);
        }
    }
    (place, best)
}
