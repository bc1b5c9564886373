//! OBJ files.

use std::path::Path;

use super::fault::{fault, too_many};
use super::triangles::{MOST_TRIANGLES, TriangleMesh};
use crate::shape_error::ShapeError;

/// The triangles of all objects of a file; faces of more corners are divided.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, ShapeError> {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut &*bytes, &options, no_materials)
        .map_err(|why| fault(path, format!("is not an OBJ file that can be read: {why}")))?;
    let mut mesh = TriangleMesh::default();
    for model in &models {
        let first = mesh.vertices.len();
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        let corners = |t: &[u32]| [t[0], t[1], t[2]].map(|k| first + k as usize);
        mesh.triangles.extend(model.mesh.indices.chunks_exact(3).map(corners));
        if mesh.triangles.len() > MOST_TRIANGLES {
            return Err(too_many(path, mesh.triangles.len()));
        }
    }
    Ok(mesh)
}
