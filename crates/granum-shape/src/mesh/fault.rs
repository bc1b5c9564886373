//! Errors about files.

use std::path::Path;

use super::triangles::MOST_TRIANGLES;
use crate::shape_error::ShapeError;

/// An error about a file.
pub(crate) fn fault(path: &Path, message: impl std::fmt::Display) -> ShapeError {
    ShapeError::new("file", format!("{:?} {message}", path.display().to_string()))
}

/// An error about too many triangles.
pub(super) fn too_many(path: &Path, count: usize) -> ShapeError {
    let message = format!(
        "has {count} triangles or more; decimate it to at most {MOST_TRIANGLES}: some ten thousand are plenty for a cover of spheres"
    );
    fault(path, message)
}
