//! A mesh of triangles.

use granum_core::assembly::Vector;

/// Largest number of triangles of a mesh.
pub const MOST_TRIANGLES: usize = 1_000_000;
/// A surface of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The corners, in any unit of length.
    pub vertices: Vec<Vector>,
    /// Three corners each, anticlockwise seen from outside.
    pub triangles: Vec<[usize; 3]>,
}

impl TriangleMesh {
    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles[triangle].map(|k| self.vertices[k])
    }

    /// Triangles that are given by their corners, without knowing which corners are shared.
    pub(crate) fn of_corners(corners: Vec<Vector>) -> TriangleMesh {
        let triangles = (0..corners.len() / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        TriangleMesh { vertices: corners, triangles }
    }
}
