//! Volume, surface, centre and inertia of a closed surface by the divergence theorem: sums over the tetrahedra of a local origin and the
//! triangles. The origin is the middle of the mesh, so that large coordinates cost no digits.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{cross, dot, length};

use super::bounds::bounds;
use super::triangles::TriangleMesh;
use crate::union_of_spheres::Moments;

/// The moments of the body within a closed surface; the volume is negative if its triangles are turned inwards.
pub fn moments(mesh: &TriangleMesh) -> Moments {
    let [low, high] = bounds(&mesh.vertices);
    let origin: Vector = std::array::from_fn(|a| low[a] + 0.5 * (high[a] - low[a]));
    let mut sums = Moments::default();
    let mut first = [0.0; 3];
    for k in 0..mesh.triangles.len() {
        let corners = mesh.corners(k).map(|p| -> Vector { std::array::from_fn(|a| p[a] - origin[a]) });
        let [p, q, r] = &corners;
        let edge = |from: &Vector, to: &Vector| -> Vector { std::array::from_fn(|a| to[a] - from[a]) };
        sums.surface += 0.5 * length(&cross(&edge(p, q), &edge(p, r)));
        let volume = dot(p, &cross(q, r)) / 6.0;
        sums.volume += volume;
        let sum: Vector = std::array::from_fn(|a| p[a] + q[a] + r[a]);
        for a in 0..3 {
            first[a] += 0.25 * volume * sum[a];
            for b in 0..3 {
                // int x x^T of a tetrahedron with a corner in the origin: V/20 (s s^T + sum of p p^T), s the sum of its corners.
                let own: f64 = corners.iter().map(|c| c[a] * c[b]).sum();
                sums.second[a][b] += volume / 20.0 * (sum[a] * sum[b] + own);
            }
        }
    }
    let apart = first.map(|x| x / sums.volume);
    let second: Matrix = std::array::from_fn(|a| {
        std::array::from_fn(|b| sums.second[a][b] - sums.volume * apart[a] * apart[b])
    });
    Moments { centre: std::array::from_fn(|a| origin[a] + apart[a]), second, ..sums }
}
