//! Whether a surface crosses itself: an edge of one triangle goes through another. Triangles of one plane that overlap are not found.

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, dot};

use super::tree::Tree;
use super::triangles::TriangleMesh;

/// Volumes below this share of the cube of the size of two triangles count as zero: a touch is no crossing.
const ZERO: f64 = 1e-12;

/// Two triangles that cross each other, if there are any.
pub(super) fn crossing(mesh: &TriangleMesh) -> Option<[usize; 2]> {
    Tree::new(mesh).find_pair(&|a, b| cross_each_other(mesh, a, b))
}

fn cross_each_other(mesh: &TriangleMesh, a: usize, b: usize) -> bool {
    let (first, second) = (mesh.triangles[a], mesh.triangles[b]);
    let shared = |k: usize| first.contains(&k) && second.contains(&k);
    if first.iter().filter(|k| shared(**k)).count() > 1 {
        return false;
    }
    let one_way = |edges: [usize; 3], face: [usize; 3]| {
        (0..3).map(|k| [edges[k], edges[(k + 1) % 3]]).any(|[p, q]| {
            let apart = !shared(p) && !shared(q);
            apart && goes_through([mesh.vertices[p], mesh.vertices[q]], face.map(|k| mesh.vertices[k]))
        })
    };
    one_way(first, second) || one_way(second, first)
}

/// True if a segment goes through the inside of a triangle.
fn goes_through([p, q]: [Vector; 2], [a, b, c]: [Vector; 3]) -> bool {
    let size = |x: &Vector| (0..3).map(|k| (x[k] - a[k]).abs()).fold(0.0, f64::max);
    let scale = [p, q, b, c].iter().map(size).fold(0.0, f64::max);
    let zero = ZERO * scale * scale * scale;
    let volume = |x: &Vector, y: &Vector, z: &Vector, from: &Vector| {
        let [x, y, z] = [x, y, z].map(|v| -> Vector { std::array::from_fn(|k| v[k] - from[k]) });
        dot(&x, &cross(&y, &z))
    };
    let (above, below) = (volume(&b, &c, &p, &a), volume(&b, &c, &q, &a));
    if !(above > zero && below < -zero || above < -zero && below > zero) {
        return false;
    }
    let sides = [volume(&q, &a, &b, &p), volume(&q, &b, &c, &p), volume(&q, &c, &a, &p)];
    sides.iter().all(|v| *v > zero) || sides.iter().all(|v| *v < -zero)
}
