//! STL files. Those of text are read with the full digits of their numbers: a grain that is far from the origin needs them.

use std::path::Path;

use granum_core::assembly::Vector;

use super::fault::{fault, too_many};
use super::triangles::{MOST_TRIANGLES, TriangleMesh};
use crate::shape_error::ShapeError;

/// Bytes before the triangles of a binary file, and of each triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The triangles of a file of text or of bytes. A binary file is known by its length, since some begin with `solid` too.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, ShapeError> {
    let count = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let binary = count.is_some_and(|count| bytes.len() == HEADER + TRIANGLE * count);
    let begins = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    match count {
        Some(count) if binary => of_bytes(path, &bytes[HEADER..], count),
        _ if begins => of_text(path, &String::from_utf8_lossy(bytes)),
        Some(count) => {
            let expected = HEADER as u64 + TRIANGLE as u64 * count as u64;
            let message = format!(
                "is not an STL file, or is cut off: it has {} bytes, and {count} triangles as its header says need {expected}",
                bytes.len()
            );
            Err(fault(path, message))
        }
        None => Err(fault(
            path,
            "is not an STL file: it neither begins with \"solid\" nor has a header of 84 bytes",
        )),
    }
}

fn of_bytes(path: &Path, bytes: &[u8], count: usize) -> Result<TriangleMesh, ShapeError> {
    if count > MOST_TRIANGLES {
        return Err(too_many(path, count));
    }
    let mut corners: Vec<Vector> = Vec::with_capacity(3 * count);
    for triangle in bytes.chunks_exact(TRIANGLE) {
        // A normal, which the order of the corners replaces, three corners and two bytes.
        for corner in triangle[12..48].chunks_exact(12) {
            let number = |k: usize| {
                let b = &corner[4 * k..4 * k + 4];
                f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            };
            corners.push([number(0), number(1), number(2)]);
        }
    }
    Ok(TriangleMesh::of_corners(corners))
}

fn of_text(path: &Path, text: &str) -> Result<TriangleMesh, ShapeError> {
    let mut corners: Vec<Vector> = Vec::new();
    let mut in_facet = 0;
    for (k, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z] = numbers[..] else {
                    let message = format!(
                        "is not an STL file: line {} is {line:?}, not \"vertex\" and three numbers",
                        k + 1
                    );
                    return Err(fault(path, message));
                };
                corners.push([x, y, z]);
                in_facet += 1;
            }
            Some("endfacet") if in_facet != 3 => {
                let message =
                    format!("has a facet of {in_facet} corners before line {}; STL has triangles", k + 1);
                return Err(fault(path, message));
            }
            Some("endfacet") => in_facet = 0,
            _ => {}
        }
        if corners.len() > 3 * MOST_TRIANGLES {
            return Err(too_many(path, MOST_TRIANGLES + 1));
        }
    }
    if in_facet != 0 {
        return Err(fault(path, "is cut off: its last facet has no end"));
    }
    Ok(TriangleMesh::of_corners(corners))
}
