//! Points of a surface.

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, length};

use crate::mesh::TriangleMesh;
use crate::mesh::bounds::bounds;

/// The largest edge of a triangle that stands for one point, over the largest length of the mesh.
const EDGE: f64 = 0.04;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    pub place: Vector,
    /// The unit vector outwards.
    pub normal: Vector,
    /// The area for which it stands.
    pub area: f64,
}

/// The middles of the triangles of a mesh, where large triangles are divided, and the largest edge of these.
pub(crate) fn samples(mesh: &TriangleMesh) -> (Vec<Sample>, f64) {
    let [low, high] = bounds(&mesh.vertices);
    let longest = (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
    let mut found = Vec::new();
    for k in 0..mesh.triangles.len() {
        divide(&mesh.corners(k), EDGE * longest, &mut found);
    }
    (found, EDGE * longest)
}

/// Halves the longest edge until it is short.
fn divide(corners: &[Vector; 3], edge: f64, found: &mut Vec<Sample>) {
    let minus = |p: &Vector, q: &Vector| -> Vector { std::array::from_fn(|k| p[k] - q[k]) };
    let long = |k: usize| length(&minus(&corners[(k + 1) % 3], &corners[k]));
    let longest = (1..3).fold(0, |best, k| if long(k) > long(best) { k } else { best });
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    if long(longest) > edge {
        let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        divide(&[a, middle, c], edge, found);
        divide(&[middle, b, c], edge, found);
        return;
    }
    let normal = cross(&minus(&b, &a), &minus(&c, &a));
    let twice = length(&normal);
    if twice > 0.0 {
        let place = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
        found.push(Sample { place, normal: normal.map(|x| x / twice), area: 0.5 * twice });
    }
}
