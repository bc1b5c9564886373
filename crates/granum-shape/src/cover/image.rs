//! Moments and surface of a body of voxels.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::length;

use super::grid::Grid;
use super::report::Original;
use super::samples::Sample;
use crate::union_of_spheres::Moments;

/// Voxels along the shortest side that are wanted.
const FINE: usize = 48;

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

/// The indicator of a body smoothed by passes of the weights 1/4, 1/2, 1/4 along each axis.
struct Smooth {
    size: [usize; 3],
    field: Vec<f64>,
}

impl Smooth {
    /// With further empty voxels around the grid, into which the indicator spreads.
    fn new(grid: &Grid, rim: usize, passes: usize) -> Smooth {
        let size = grid.size.map(|n| n + 2 * rim);
        let mut smooth = Smooth { size, field: vec![0.0; size.iter().product()] };
        let [nx, ny, _] = grid.size;
        for k in (0..grid.inside.len()).filter(|k| grid.inside[*k]) {
            let place = smooth.at([k % nx + rim, k / nx % ny + rim, k / nx / ny + rim]);
            smooth.field[place] = 1.0;
        }
        let stride = smooth.stride();
        for axis in (0..passes).flat_map(|_| 0..3) {
            let before = smooth.field.clone();
            for k in 0..before.len() {
                if smooth.is_inner(k) {
                    let beside = before[k - stride[axis]] + before[k + stride[axis]];
                    smooth.field[k] = 0.5 * before[k] + 0.25 * beside;
                }
            }
        }
        smooth
    }

    fn at(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    fn stride(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    fn is_inner(&self, k: usize) -> bool {
        let [nx, ny, _] = self.size;
        [k % nx, k / nx % ny, k / nx / ny].iter().zip(self.size).all(|(x, n)| *x > 0 && x + 1 < n)
    }
}

/// Surface of a body of voxels: the integral of the length of the gradient of its smoothed indicator. The faces of the voxels would give half
/// as much again for a sphere.
fn surface(grid: &Grid) -> f64 {
    let smooth = Smooth::new(grid, 3, 2);
    let (field, stride) = (&smooth.field, smooth.stride());
    let slope = |k: usize| {
        let along = |a: usize| (field[k + stride[a]] - field[k - stride[a]]) / (2.0 * grid.step[a]);
        length(&[along(0), along(1), along(2)])
    };
    let inner = (0..field.len()).filter(|k| smooth.is_inner(*k));
    inner.map(slope).sum::<f64>() * grid.step.iter().product::<f64>()
}

/// A grid of few voxels with each of them divided, up to four times along each axis, within the surface on which the smoothed indicator is one
/// half: spheres have finer places and radii than voxels, and meet no stairs.
pub(super) fn divided(grid: &Grid) -> Grid {
    let fewest = grid.size.iter().map(|n| n - 2).min().unwrap_or(1).max(1);
    let parts = FINE.div_ceil(fewest).clamp(1, 4);
    let smooth = Smooth::new(grid, 1, 1);
    let size = grid.size.map(|n| n * parts);
    // The voxel below a part, and the share of the one above it.
    let between = |part: usize| {
        let place = 1.0 + (part as f64 + 0.5) / parts as f64 - 0.5;
        (place.floor() as usize, place - place.floor())
    };
    let mut inside = Vec::with_capacity(size.iter().product());
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let ends = [between(x), between(y), between(z)];
                let corner = |k: usize| {
                    let above = [k & 1, k >> 1 & 1, k >> 2 & 1];
                    let share = |a: usize| if above[a] == 1 { ends[a].1 } else { 1.0 - ends[a].1 };
                    let place = smooth.at(std::array::from_fn(|a| ends[a].0 + above[a]));
                    share(0) * share(1) * share(2) * smooth.field[place]
                };
                inside.push((0..8).map(corner).sum::<f64>() >= 0.5);
            }
        }
    }
    // What is thinner than a voxel would vanish.
    if !inside.contains(&true) {
        return grid.clone();
    }
    let step = grid.step.map(|h| h / parts as f64);
    Grid {
        size,
        step,
        first: std::array::from_fn(|a| grid.first[a] - 0.5 * grid.step[a] + 0.5 * step[a]),
        inside,
    }
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

    fn ball() -> Grid {
        let size = [43, 43, 23];
        let mut grid = Grid {
            size,
            step: [1.0, 1.0, 2.0],
            first: [-21.0, -21.0, -22.0],
            inside: vec![false; size.iter().product()],
        };
        for k in 0..grid.inside.len() {
            grid.inside[k] = length(&grid.centre(k)) < 20.0;
        }
        grid
    }

    /// A ball of voxels that are twice as long along z.
    #[test]
    fn a_ball_of_unlike_voxels_has_its_moments_and_its_surface() {
        let found = moments(&ball());
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

    /// Divided voxels are the same body: its volume and its place stay, and its surface has fewer stairs.
    #[test]
    fn divided_voxels_are_the_same_body() {
        let (coarse, fine) = (ball(), divided(&ball()));
        assert_eq!(fine.size, coarse.size.map(|n| 3 * n));
        let (a, b) = (moments(&coarse), moments(&fine));
        assert!((b.volume / a.volume - 1.0).abs() < 0.01, "{} {}", a.volume, b.volume);
        assert!(b.centre.iter().all(|x| x.abs() < 5e-3), "{:?}", b.centre);
        let away = |grid: &Grid| {
            let samples = faces(grid);
            samples.iter().map(|s| (length(&s.place) - 20.0).abs()).sum::<f64>() / samples.len() as f64
        };
        assert!(away(&fine) < 0.7 * away(&coarse), "{} {}", away(&fine), away(&coarse));
    }
}
