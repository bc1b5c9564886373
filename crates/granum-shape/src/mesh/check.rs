//! Whether a mesh is the closed surface of one body, and what can be mended.

use std::path::Path;

use granum_core::assembly::Vector;

use super::bounds::bounds;
use super::crossing::crossing;
use super::fault::{fault, too_many};
use super::moments::moments;
use super::triangles::{MOST_TRIANGLES, TriangleMesh};
use crate::shape_error::ShapeError;

/// Volumes below this share of the box around a mesh count as none.
const NO_VOLUME: f64 = 1e-9;

/// Largest coordinate: moments of inertia are fifth powers of it.
const LARGEST: f64 = 1e50;

/// A mesh whose equal corners are joined and that is the closed, outward surface of one body that does not cross itself. Triangles without
/// an area are left out, and triangles that look inwards are turned: the notices tell it.
///
/// # Errors
/// The key `file`, with the name of the file, what is wrong with it and what would be right.
pub fn checked(
    mesh: TriangleMesh,
    path: &Path,
    notices: &mut Vec<String>,
) -> Result<TriangleMesh, ShapeError> {
    let refused = |message: String| Err(fault(path, message));
    let mut notice = |message: String| notices.push(format!("{:?} {message}", path.display().to_string()));
    let count = mesh.triangles.len();
    if count == 0 {
        return refused("has no triangles; a shape needs a closed surface of them".into());
    }
    if count > MOST_TRIANGLES {
        return Err(too_many(path, count));
    }
    if let Some((k, p)) = mesh.vertices.iter().enumerate().find(|(_, p)| p.iter().any(|x| !x.is_finite())) {
        return refused(format!("has the corner {k} at {p:?}; coordinates must be finite numbers"));
    }
    if let Some((k, p)) = mesh.vertices.iter().enumerate().find(|(_, p)| p.iter().any(|x| x.abs() > LARGEST))
    {
        return refused(format!(
            "has the corner {k} at {p:?}; coordinates must be at most {LARGEST:e}, beyond which a volume and its moments are no numbers"
        ));
    }
    if let Some(k) = mesh.triangles.iter().position(|t| t.iter().any(|c| *c >= mesh.vertices.len())) {
        let message = format!(
            "has a triangle {k} with a corner that does not exist; there are {} corners",
            mesh.vertices.len()
        );
        return refused(message);
    }
    let mut mesh = joined(&mesh);
    let left_out = count - mesh.triangles.len();
    if left_out > 0 {
        notice(format!("has {left_out} triangles with two equal corners; they are left out"));
    }
    if mesh.triangles.is_empty() {
        return refused("has only triangles with two equal corners".into());
    }
    let [low, high] = bounds(&mesh.vertices);
    if let Some(a) = (0..3).find(|&a| high[a] <= low[a]) {
        return refused(format!("is flat: all corners have {} = {}", ["x", "y", "z"][a], low[a]));
    }
    let edges = edges(&mesh);
    let sides =
        |test: fn(usize) -> bool| edges.chunk_by(|a, b| a.ends == b.ends).filter(|e| test(e.len())).count();
    let (open, crowded) = (sides(|n| n == 1), sides(|n| n > 2));
    if open > 0 {
        return refused(format!(
            "is not closed: it has {open} open edges, which belong to one triangle only; fill its holes, and join corners that are almost at one place"
        ));
    }
    if crowded > 0 {
        return refused(format!(
            "has {crowded} edges at which more than two triangles meet; unite or part what meets there"
        ));
    }
    let shells = shells(&mesh, &edges);
    if let Some([a, b]) = shells.twisted {
        return refused(format!(
            "has no inside and outside: the triangles {a} and {b} cannot look to the same side"
        ));
    }
    if shells.count > 1 {
        return refused(format!(
            "has {} separate shells; a shape is one body: unite them, or write each to a file of its own",
            shells.count
        ));
    }
    let turned = shells.turned.iter().filter(|turned| **turned).count();
    if turned > 0 {
        notice(format!("has {turned} triangles that look to the other side than the rest; they are turned"));
        turn(&mut mesh, |k| shells.turned[k]);
    }
    if let Some([a, b]) = crossing(&mesh) {
        let p = mesh.corners(a)[0];
        return refused(format!(
            "crosses itself: the triangles {a} and {b} near {p:?} go through each other; mend it first"
        ));
    }
    let volume = moments(&mesh).volume;
    let around: f64 = (0..3).map(|a| high[a] - low[a]).product();
    if volume.abs() <= NO_VOLUME * around {
        return refused(format!("encloses no volume: it is {volume}, and the box around it {around}"));
    }
    if volume < 0.0 {
        notice("was inside out; its triangles are turned".into());
        turn(&mut mesh, |_| true);
    }
    Ok(mesh)
}

fn turn(mesh: &mut TriangleMesh, which: impl Fn(usize) -> bool) {
    for (k, triangle) in mesh.triangles.iter_mut().enumerate() {
        if which(k) {
            triangle.swap(1, 2);
        }
    }
}

/// The same mesh with equal corners joined, without triangles two of whose corners are equal.
fn joined(mesh: &TriangleMesh) -> TriangleMesh {
    // Minus zero is zero.
    let places: Vec<Vector> = mesh.vertices.iter().map(|p| p.map(|x| x + 0.0)).collect();
    let compare = |a: &Vector, b: &Vector| {
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
    };
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| compare(&places[a], &places[b]).then(a.cmp(&b)));
    // The first of equal corners stands for them.
    let mut stands = vec![0; places.len()];
    for group in order.chunk_by(|&a, &b| compare(&places[a], &places[b]).is_eq()) {
        group.iter().for_each(|k| stands[*k] = group[0]);
    }
    let mut number = vec![usize::MAX; places.len()];
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|k| stands[k]);
        if a == b || b == c || c == a {
            continue;
        }
        triangles.push([a, b, c].map(|k| {
            if number[k] == usize::MAX {
                number[k] = vertices.len();
                vertices.push(places[k]);
            }
            number[k]
        }));
    }
    TriangleMesh { vertices, triangles }
}

/// A side of a triangle.
struct Edge {
    /// Its ends, the smaller number first.
    ends: [usize; 2],
    triangle: usize,
    /// True if the triangle goes from the larger to the smaller number.
    back: bool,
}

/// The sides of all triangles; those of one edge follow each other.
fn edges(mesh: &TriangleMesh) -> Vec<Edge> {
    let of_triangle = |(triangle, t): (usize, &[usize; 3])| {
        [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| Edge {
            ends: [a.min(b), a.max(b)],
            triangle,
            back: a > b,
        })
    };
    let mut edges: Vec<Edge> = mesh.triangles.iter().enumerate().flat_map(of_triangle).collect();
    edges.sort_by_key(|edge| (edge.ends, edge.triangle));
    edges
}

/// What follows from the neighbours of triangles.
struct Shells {
    /// Number of connected surfaces.
    count: usize,
    /// Triangles that look to the other side than most of the triangles.
    turned: Vec<bool>,
    /// Neighbours that cannot look to the same side.
    twisted: Option<[usize; 2]>,
}

fn shells(mesh: &TriangleMesh, edges: &[Edge]) -> Shells {
    let mut neighbours = vec![Vec::with_capacity(3); mesh.triangles.len()];
    for pair in edges.chunk_by(|a, b| a.ends == b.ends) {
        // Neighbours that look to the same side run along their edge in opposite directions.
        let differ = pair[0].back == pair[1].back;
        neighbours[pair[0].triangle].push((pair[1].triangle, differ));
        neighbours[pair[1].triangle].push((pair[0].triangle, differ));
    }
    let mut side: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut found = Shells { count: 0, turned: Vec::new(), twisted: None };
    for start in 0..side.len() {
        if side[start].is_some() {
            continue;
        }
        found.count += 1;
        side[start] = Some(false);
        let mut open = vec![start];
        while let Some(a) = open.pop() {
            for &(b, differ) in &neighbours[a] {
                let wanted = side[a].map(|side| side != differ);
                if side[b].is_none() {
                    side[b] = wanted;
                    open.push(b);
                } else if side[b] != wanted && found.twisted.is_none() {
                    found.twisted = Some([a.min(b), a.max(b)]);
                }
            }
        }
    }
    found.turned = side.into_iter().map(|side| side == Some(true)).collect();
    let others = found.turned.iter().filter(|turned| **turned).count();
    if 2 * others > found.turned.len() {
        found.turned.iter_mut().for_each(|turned| *turned = !*turned);
    }
    found
}
