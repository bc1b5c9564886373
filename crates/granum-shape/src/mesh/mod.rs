//! Meshes of triangles: read from a file, checked, measured.

pub(crate) mod bounds;
mod check;
mod crossing;
mod moments;
mod obj;
mod ply;
mod stl;
mod tree;

use std::path::Path;

use granum_core::assembly::Vector;

use crate::family::ShapeError;

pub use check::checked;
pub use moments::moments;
pub(crate) use tree::Tree;

/// Largest number of triangles of a mesh.
pub const MOST_TRIANGLES: usize = 1_000_000;
/// Largest size of a file, bytes.
const LARGEST_FILE: u64 = 1 << 30;

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

/// An error about a file.
pub(crate) fn fault(path: &Path, message: impl std::fmt::Display) -> ShapeError {
    ShapeError::new("file", format!("{:?} {message}", path.display().to_string()))
}

/// An error about too many triangles.
fn too_many(path: &Path, count: usize) -> ShapeError {
    let message = format!(
        "has {count} triangles or more; decimate it to at most {MOST_TRIANGLES}: some ten thousand are plenty for a cover of spheres"
    );
    fault(path, message)
}

/// Reads a closed surface of one body from an STL (text or binary), OBJ or PLY file. What was mended is told in the notices.
///
/// # Errors
/// The key `file`, with the name of the file, what is wrong with it and what would be right.
pub fn read(path: &Path, notices: &mut Vec<String>) -> Result<TriangleMesh, ShapeError> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let parse: fn(&Path, &[u8]) -> Result<TriangleMesh, ShapeError> = match ending.as_str() {
        "stl" => stl::parse,
        "obj" => obj::parse,
        "ply" => ply::parse,
        _ => {
            let message = "is not a mesh by its name, which must end in .stl, .obj or .ply";
            return Err(fault(path, message));
        }
    };
    let size = std::fs::metadata(path).map_err(|why| fault(path, format!("cannot be read: {why}")))?;
    if size.len() > LARGEST_FILE {
        let message =
            format!("has {} bytes; decimate the mesh to at most {MOST_TRIANGLES} triangles", size.len());
        return Err(fault(path, message));
    }
    let bytes = std::fs::read(path).map_err(|why| fault(path, format!("cannot be read: {why}")))?;
    checked(parse(path, &bytes)?, path, notices)
}

#[cfg(test)]
pub(crate) mod tests;
