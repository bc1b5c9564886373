//! Moments and surface of a body of voxels.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::length;

use super::grid::Grid;
use super::report::Original;
use super::samples::Sample;
use crate::union_of_spheres::Moments;

impl Original {
    /// A body of voxels, each of them a small box.
    pub(crate) fn of_grid(grid: &Grid) -> Original {
        Original { moments: moments(grid), samples: faces(grid) }
    }
}

fn moments(grid: &Grid) -> Moments {
    let inside = || (0..grid.inside.len()).filter(|k| grid.inside[*k]).map(|k| grid.centre(k));
    let voxel: f64 = grid.step.iter().product();
    let count = inside().count() as f64;
    let centre: Vector = std::array::from_fn(|a| inside().map(|p| p[a]).sum::<f64>() / count);
    let mut second: Matrix = [[0.0; 3]; 3];
    for p in inside() {
        for a in 0..3 {
            for b in 0..3 {
                second[a][b] += voxel * (p[a] - centre[a]) * (p[b] - centre[b]);
            }
        }
    }
    for a in 0..3 {
        // That of a box about its own centre.
        second[a][a] += voxel * count * grid.step[a] * grid.step[a] / 12.0;
    }
    Moments { volume: voxel * count, surface: surface(grid), centre, second }
}

/// Surface of a body of voxels: the integral of the length of the gradient of its smoothed indicator. The faces of the voxels would give half
/// as much again for a sphere.
fn surface(grid: &Grid) -> f64 {
    const RIM: usize = 3;
    let size = grid.size.map(|n| n + 2 * RIM);
    let [nx, ny, _] = size;
    let at = |x: usize, y: usize, z: usize| x + nx * (y + ny * z);
    let mut field = vec![0.0; size.iter().product()];
    for (k, _) in grid.inside.iter().enumerate().filter(|(_, is)| **is) {
        let [x, y, z] = [k % grid.size[0], k / grid.size[0] % grid.size[1], k / grid.size[0] / grid.size[1]];
        field[at(x + RIM, y + RIM, z + RIM)] = 1.0;
    }
    let stride = [1, nx, nx * ny];
    let inner =
        |k: usize| [k % nx, k / nx % ny, k / nx / ny].iter().zip(size).all(|(x, n)| *x > 0 && x + 1 < n);
    // Two passes of the weights 1/4, 1/2, 1/4 along each axis.
    for axis in [0, 1, 2, 0, 1, 2] {
        let before = field.clone();
        for k in (0..field.len()).filter(|k| inner(*k)) {
            field[k] = 0.5 * before[k] + 0.25 * (before[k - stride[axis]] + before[k + stride[axis]]);
        }
    }
    let slope = |k: usize| {
        let along = |a: usize| (field[k + stride[a]] - field[k - stride[a]]) / (2.0 * grid.step[a]);
        length(&[along(0), along(1), along(2)])
    };
    (0..field.len()).filter(|k| inner(*k)).map(slope).sum::<f64>() * grid.step.iter().product::<f64>()
}

/// The middles of the faces between voxels inside and outside.
fn faces(grid: &Grid) -> Vec<Sample> {
    let [nx, ny, _] = grid.size;
    let stride = [1, nx, nx * ny];
    let mut found = Vec::new();
    for k in (0..grid.inside.len()).filter(|k| grid.inside[*k]) {
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let other = if side < 0.0 { k - stride[axis] } else { k + stride[axis] };
                if !grid.inside[other] {
                    let normal: Vector = std::array::from_fn(|a| if a == axis { side } else { 0.0 });
                    let centre = grid.centre(k);
                    let place = std::array::from_fn(|a| centre[a] + 0.5 * grid.step[a] * normal[a]);
                    let area = grid.step.iter().product::<f64>() / grid.step[axis];
                    found.push(Sample { place, normal, area });
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of voxels that are twice as long along z.
    #[test]
    fn a_ball_of_unlike_voxels_has_its_moments_and_its_surface() {
        let (radius, step) = (20.0, [1.0, 1.0, 2.0]);
        let size = [43, 43, 23];
        let mut grid = Grid { size, step, first: [-21.0, -21.0, -22.0], inside: vec![false; 43 * 43 * 23] };
        for k in 0..grid.inside.len() {
            grid.inside[k] = length(&grid.centre(k)) < radius;
        }
        let found = moments(&grid);
        let pi = std::f64::consts::PI;
        assert!((found.volume / (4.0 / 3.0 * pi * 8000.0) - 1.0).abs() < 0.01, "{}", found.volume);
        assert!(
            (found.surface / (4.0 * pi * 400.0) - 1.0).abs() < 0.02,
            "{}",
            found.surface / (4.0 * pi * 400.0)
        );
        for a in 0..3 {
            assert!((found.inertia_over_volume()[a][a] / 160.0 - 1.0).abs() < 0.01);
            assert!(found.centre[a].abs() < 1e-9);
        }
    }
}
