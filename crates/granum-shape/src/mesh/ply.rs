//! PLY files, of text or binary.

use std::path::Path;

use granum_core::assembly::Vector;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{PropertyAccess, PropertyAccessResult};

use super::fault::{fault, too_many};
use super::triangles::{MOST_TRIANGLES, TriangleMesh};
use crate::shape_error::ShapeError;

/// A corner.
#[derive(Default)]
struct Corner(Vector);

impl Corner {
    fn set(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        match name {
            "x" => self.0[0] = value,
            "y" => self.0[1] = value,
            "z" => self.0[2] = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// Methods of `PropertyAccess` that take a number of one type, or a list of them.
macro_rules! numbers {
    ($($method:ident: $type:ty,)*) => {
        $(fn $method(&mut self, name: &str, value: $type) -> PropertyAccessResult {
            self.set(name, f64::from(value))
        })*
    };
}

impl PropertyAccess for Corner {
    fn new() -> Self {
        Corner([f64::NAN; 3])
    }

    numbers! {
        set_char: i8,
        set_uchar: u8,
        set_short: i16,
        set_ushort: u16,
        set_int: i32,
        set_uint: u32,
        set_float: f32,
        set_double: f64,
    }
}

/// A face: the numbers of its corners, negative where they are impossible.
#[derive(Default)]
struct Face(Vec<i64>);

macro_rules! lists {
    ($($method:ident: $type:ty,)*) => {
        $(fn $method(&mut self, name: &str, value: Vec<$type>) -> PropertyAccessResult {
            if !matches!(name, "vertex_indices" | "vertex_index") {
                return PropertyAccessResult::Ignored;
            }
            self.0 = value.into_iter().map(i64::from).collect();
            PropertyAccessResult::Set
        })*
    };
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }

    lists! {
        set_list_char: i8,
        set_list_uchar: u8,
        set_list_short: i16,
        set_list_ushort: u16,
        set_list_int: i32,
        set_list_uint: u32,
    }
}

/// The triangles of a file; faces of more corners are divided from their first one.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, ShapeError> {
    let refused =
        |why: &dyn std::fmt::Display| fault(path, format!("is not a PLY file that can be read: {why}"));
    let mut reader = Reader::new(bytes);
    let (of_corners, of_faces) = (Parser::<Corner>::new(), Parser::<Face>::new());
    let header = of_corners.read_header(&mut reader).map_err(|why| refused(&why))?;
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        if name == "face" && element.count > MOST_TRIANGLES {
            return Err(too_many(path, element.count));
        }
        // Other elements are read past.
        if name == "vertex" {
            corners = of_corners
                .read_payload_for_element(&mut reader, element, &header)
                .map_err(|why| refused(&why))?;
        } else {
            let read = of_faces
                .read_payload_for_element(&mut reader, element, &header)
                .map_err(|why| refused(&why))?;
            if name == "face" {
                faces = read;
            }
        }
    }
    let mut mesh =
        TriangleMesh { vertices: corners.into_iter().map(|c| c.0).collect(), triangles: Vec::new() };
    for face in faces {
        // An impossible number becomes one beyond the corners, which the check refuses.
        let face: Vec<usize> = face.0.iter().map(|k| usize::try_from(*k).unwrap_or(usize::MAX)).collect();
        mesh.triangles.extend(face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]));
        if mesh.triangles.len() > MOST_TRIANGLES {
            return Err(too_many(path, mesh.triangles.len()));
        }
    }
    Ok(mesh)
}
