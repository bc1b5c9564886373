//! A body of a file with the spheres that stand for it.

use super::Cover;
use super::grid::Grid;
use crate::mesh::{TriangleMesh, moments};

/// A body of a file with the spheres that stand for it.
#[derive(Clone, Debug, PartialEq)]
pub struct CoveredBody {
    /// Its label in a stack of images.
    pub label: Option<u32>,
    /// Its volume, in the unit of length of the file.
    pub volume: f64,
    /// The spheres, and how well they cover it.
    pub cover: Cover,
    /// Its surface, in the axes of the spheres.
    pub surface: TriangleMesh,
}

impl CoveredBody {
    /// The body within a closed surface, which is given in the axes of the spheres.
    pub(crate) fn of_mesh(surface: TriangleMesh, cover: Cover) -> CoveredBody {
        CoveredBody { label: None, volume: moments(&surface).volume, cover, surface }
    }

    /// A body of voxels.
    pub(crate) fn of_grid(label: u32, grid: &Grid, cover: Cover) -> CoveredBody {
        let count = grid.inside.iter().filter(|inside| **inside).count();
        let volume = count as f64 * grid.step.iter().product::<f64>();
        CoveredBody { label: Some(label), volume, cover, surface: faces(grid) }
    }
}

/// The faces of voxels towards what is not the body: two triangles each.
fn faces(grid: &Grid) -> TriangleMesh {
    let strides = [1, grid.size[0], grid.size[0] * grid.size[1]];
    let mut corners = Vec::new();
    for k in (0..grid.inside.len()).filter(|k| grid.inside[*k]) {
        let centre = grid.centre(k);
        for axis in 0..3 {
            // The rim is empty, so that all neighbours exist.
            for (side, neighbour) in [(-1.0, k - strides[axis]), (1.0, k + strides[axis])] {
                if grid.inside[neighbour] {
                    continue;
                }
                let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
                let corner = |u: f64, v: f64| {
                    let mut place = centre;
                    place[axis] += 0.5 * side * grid.step[axis];
                    // Anticlockwise seen from outside: the other way round on the lower side.
                    place[b] += 0.5 * side * u * grid.step[b];
                    place[c] += 0.5 * v * grid.step[c];
                    place
                };
                let square = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                corners.extend([0, 1, 2, 0, 2, 3].map(|k: usize| square[k]));
            }
        }
    }
    TriangleMesh::of_corners(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_faces_of_voxels_enclose_their_volume() {
        let mut inside = vec![false; 4 * 3 * 3];
        inside[1 + 4 * (1 + 3)] = true;
        inside[2 + 4 * (1 + 3)] = true;
        let grid = Grid { size: [4, 3, 3], step: [1.0, 2.0, 0.5], first: [7.0, 0.0, 0.0], inside };
        let surface = faces(&grid);
        assert_eq!(surface.triangles.len(), 20);
        assert!((moments(&surface).volume - 2.0).abs() < 1e-12);
    }
}
