//! Spheres.

use crate::entry::ShapeEntry;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, Spheres};

/// A sphere.
pub struct Sphere;

impl ShapeFamily for Sphere {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "sphere",
            help: "spheres",
            parameters: &[],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, _given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        Ok(vec![vec![([0.0; 3], 0.5)]])
    }
}
