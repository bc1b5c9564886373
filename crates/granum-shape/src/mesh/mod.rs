//! Meshes of triangles: read from a file, checked, measured.

pub(crate) mod bounds;
mod check;
mod crossing;
mod fault;
mod moments;
mod obj;
mod ply;
mod stl;
mod tree;
mod triangles;

use std::io::ErrorKind;
use std::path::Path;

use granum_core::input;

use crate::shape_error::ShapeError;

pub use check::checked;
pub(crate) use fault::fault;
pub use moments::moments;
pub(crate) use tree::Tree;
pub use triangles::{MOST_TRIANGLES, TriangleMesh};

/// Largest size of a file, bytes.
const LARGEST_FILE: u64 = 1 << 30;

/// Reads a closed surface of one body from an STL (text or binary), OBJ or PLY file. What was mended is told in the notices.
///
/// # Errors
/// The key `file`, with the name of the file, what is wrong with it and what would be right.
pub fn read(path: &Path, notices: &mut Vec<String>) -> Result<TriangleMesh, ShapeError> {
    if !input::are_there() {
        return Err(fault(path, "cannot be read: add it to the files of the case"));
    }
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
    let bytes = input::read(path, LARGEST_FILE).map_err(|why| {
        let advice = format!("; decimate the mesh to at most {MOST_TRIANGLES} triangles");
        let advice = if why.kind() == ErrorKind::FileTooLarge { &advice } else { "" };
        fault(path, format!("cannot be read: {why}{advice}"))
    })?;
    checked(parse(path, &bytes)?, path, notices)
}

#[cfg(test)]
pub(crate) mod tests;
