//! Bodies as voxels, and the exact Euclidean distance of each voxel from the outside.

use granum_core::assembly::Vector;

use crate::mesh::TriangleMesh;
use crate::mesh::bounds::bounds;

/// Largest number of voxels.
const MOST_VOXELS: f64 = 2e7;

/// A body as voxels, with a rim of empty ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Numbers of voxels along x, y and z.
    pub size: [usize; 3],
    /// Their spacings.
    pub step: Vector,
    /// Centre of the first one.
    pub first: Vector,
    /// True for those inside, x running fastest.
    pub inside: Vec<bool>,
}

impl Grid {
    /// Centre of a voxel.
    pub(crate) fn centre(&self, index: usize) -> Vector {
        let [nx, ny, _] = self.size;
        let place = [index % nx, index / nx % ny, index / nx / ny];
        std::array::from_fn(|a| self.first[a] + self.step[a] * place[a] as f64)
    }

    /// The body within a closed surface, with this number of voxels along the shortest side of the box around it: fewer if the body is so
    /// flat that there would be more than 2e7 of them.
    pub(crate) fn of_mesh(mesh: &TriangleMesh, along_shortest: usize) -> Grid {
        let [low, high] = bounds(&mesh.vertices);
        let lengths: Vector = std::array::from_fn(|a| high[a] - low[a]);
        let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let mut step = shortest / along_shortest as f64;
        let count = |step: f64| lengths.iter().map(|l| (l / step).ceil() + 2.0).product::<f64>();
        while count(step) > MOST_VOXELS {
            step *= 1.1;
        }
        // Odd numbers, so that the middle of a symmetric body is the centre of a voxel.
        let size = lengths.map(|l| (l / step).ceil() as usize + 2).map(|n| n + 1 - n % 2);
        let first = std::array::from_fn(|a| low[a] + 0.5 * lengths[a] - 0.5 * step * (size[a] as f64 - 1.0));
        let mut grid = Grid { size, step: [step; 3], first, inside: vec![false; size.iter().product()] };
        grid.fill(&crossings(mesh, &grid));
        grid
    }

    /// Fills each column along x between the places where it enters and leaves the body.
    fn fill(&mut self, crossings: &[Vec<f64>]) {
        let nx = self.size[0];
        for (column, places) in crossings.iter().enumerate() {
            let mut places = places.clone();
            places.sort_by(f64::total_cmp);
            for pair in places.chunks_exact(2) {
                let at = |x: f64| ((x - self.first[0]) / self.step[0]).ceil().clamp(0.0, nx as f64) as usize;
                self.inside[nx * column + at(pair[0])..nx * column + at(pair[1])].fill(true);
            }
        }
    }

    /// Squares of the distances of the centres of voxels from the centre of the nearest empty one (Felzenszwalb and Huttenlocher 2012).
    pub(crate) fn square_distances(&self) -> Vec<f64> {
        let [nx, ny, nz] = self.size;
        let mut squares: Vec<f64> = Vec::with_capacity(self.inside.len());
        for row in self.inside.chunks_exact(nx) {
            squares.extend(along_row(row).into_iter().map(|d| (d * self.step[0]) * (d * self.step[0])));
        }
        let mut lower = Envelope::default();
        for z in 0..nz {
            for x in 0..nx {
                lower.pass(&mut squares, x + nx * ny * z, nx, ny, self.step[1]);
            }
        }
        for y in 0..ny {
            for x in 0..nx {
                lower.pass(&mut squares, x + nx * y, nx * ny, nz, self.step[2]);
            }
        }
        squares
    }
}

/// Number of voxels to the nearest empty one of a row.
fn along_row(row: &[bool]) -> Vec<f64> {
    let far = row.len() as f64;
    let mut distances = vec![0.0; row.len()];
    let mut last = far;
    for k in 0..row.len() {
        last = if row[k] { last + 1.0 } else { 0.0 };
        distances[k] = last;
    }
    last = far;
    for k in (0..row.len()).rev() {
        last = if row[k] { last + 1.0 } else { 0.0 };
        distances[k] = f64::min(distances[k], last);
    }
    distances
}

/// The lower envelope of the parabolas `f_k + (x - x_k)^2` of a row.
#[derive(Default)]
struct Envelope {
    heights: Vec<f64>,
    /// The parabolas that are lowest somewhere, and where each begins to be.
    lowest: Vec<(usize, f64)>,
}

impl Envelope {
    /// Replaces the values of a row by those of the envelope.
    fn pass(&mut self, values: &mut [f64], first: usize, stride: usize, count: usize, step: f64) {
        self.heights.clear();
        self.heights.extend((0..count).map(|k| values[first + stride * k]));
        if self.heights.iter().all(|h| *h == 0.0) {
            return;
        }
        self.lowest.clear();
        let place = |k: usize| step * k as f64;
        for k in 0..count {
            let meets = |other: usize| {
                let (p, q) = (place(k), place(other));
                (self.heights[k] + p * p - self.heights[other] - q * q) / (2.0 * (p - q))
            };
            let mut from = f64::NEG_INFINITY;
            while let Some(&(other, begins)) = self.lowest.last() {
                from = meets(other);
                if from > begins {
                    break;
                }
                self.lowest.pop();
                from = f64::NEG_INFINITY;
            }
            self.lowest.push((k, from));
        }
        let mut here = 0;
        for k in 0..count {
            while self.lowest.get(here + 1).is_some_and(|next| next.1 < place(k)) {
                here += 1;
            }
            let apart = place(k) - place(self.lowest[here].0);
            values[first + stride * k] = self.heights[self.lowest[here].0] + apart * apart;
        }
    }
}

/// Where the columns of voxels along x cross a surface. Sides that two triangles share are judged alike, so that no column slips through.
fn crossings(mesh: &TriangleMesh, grid: &Grid) -> Vec<Vec<f64>> {
    let [_, ny, nz] = grid.size;
    let mut crossings = vec![Vec::new(); ny * nz];
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(k);
        let [low, high] = bounds(&corners);
        let range = |a: usize, n: usize| {
            let at = |x: f64| ((x - grid.first[a]) / grid.step[a]).clamp(0.0, n as f64);
            at(low[a]).floor() as usize..(at(high[a]).ceil() as usize + 1).min(n)
        };
        for z in range(2, nz) {
            for y in range(1, ny) {
                let at = [grid.first[1] + grid.step[1] * y as f64, grid.first[2] + grid.step[2] * z as f64];
                if covers(mesh, triangle, at) {
                    crossings[y + ny * z].push(height(&corners, at).clamp(low[0], high[0]));
                }
            }
        }
    }
    crossings
}

/// True if the point (y, z) is in the projection of a triangle: a line through it crosses an odd number of sides on one hand.
fn covers(mesh: &TriangleMesh, triangle: &[usize; 3], [y, z]: [f64; 2]) -> bool {
    let crossed = |k: &usize| {
        let (a, b) = (triangle[*k], triangle[(*k + 1) % 3]);
        let ([_, ya, za], [_, yb, zb]) = (mesh.vertices[a.min(b)], mesh.vertices[a.max(b)]);
        (ya > y) != (yb > y) && z < za + (y - ya) * (zb - za) / (yb - ya)
    };
    (0..3).filter(crossed).count() % 2 == 1
}

/// The x of a plane through three points at (y, z).
fn height([a, b, c]: &[Vector; 3], [y, z]: [f64; 2]) -> f64 {
    let minus = |p: &Vector| -> Vector { std::array::from_fn(|k| p[k] - a[k]) };
    let normal = granum_core::geometry::cross(&minus(b), &minus(c));
    let x = a[0] - (normal[1] * (y - a[1]) + normal[2] * (z - a[2])) / normal[0];
    if x.is_finite() { x } else { a[0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::{cube, ellipsoid};

    #[test]
    fn voxels_fill_the_volume_of_a_mesh() {
        for (mesh, volume) in [
            (cube([3.0, -2.0, 5.0], 2.0), 8.0),
            (ellipsoid([1.0, 0.7, 0.5], 5), 4.0 / 3.0 * std::f64::consts::PI * 0.35),
        ] {
            let grid = Grid::of_mesh(&mesh, 51);
            let inside = grid.inside.iter().filter(|is| **is).count() as f64;
            let found = inside * grid.step.iter().product::<f64>();
            assert!((found / volume - 1.0).abs() < 3e-3, "{found} {volume}");
            assert!(grid.size.iter().all(|n| *n >= 52));
        }
    }

    /// The transform is the least of all distances, for voxels of unlike lengths.
    #[test]
    fn distances_are_those_of_a_search_through_all_voxels() {
        let mut random = crate::random::Random::new(3, 0, 0);
        let size = [9, 7, 8];
        let rim = |k: usize| [k % 9, k / 9 % 7, k / 63].iter().zip(size).any(|(x, n)| *x == 0 || x + 1 == n);
        let inside = (0..504).map(|k| !rim(k) && random.even() < 0.93).collect();
        let grid = Grid { size, step: [1.0, 0.7, 2.0], first: [0.0; 3], inside };
        let found = grid.square_distances();
        for k in 0..504 {
            let here = grid.centre(k);
            let from = |other: usize| {
                let there = grid.centre(other);
                (0..3).map(|a| (here[a] - there[a]) * (here[a] - there[a])).sum::<f64>()
            };
            let least = (0..504).filter(|o| !grid.inside[*o]).map(from).fold(f64::INFINITY, f64::min);
            assert!((found[k] - least).abs() < 1e-12, "{k}: {} {least}", found[k]);
        }
    }
}
