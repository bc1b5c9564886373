//! Four equal spheres at the corners of a tetrahedron.

use crate::entry::ShapeEntry;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};

/// Four equal spheres at the corners of a regular tetrahedron.
pub struct Tetrapod;

const ARM: ShapeParameter = ShapeParameter {
    key: "arm",
    default: 0.43301270189221935,
    bounds: [0.05, 0.612],
    whole: false,
    meaning: "Distance of the centres of the spheres of a tetrapod from its centre over their diameter.",
};

impl ShapeFamily for Tetrapod {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "tetrapod",
            help: "four equal spheres at the corners of a tetrahedron",
            parameters: &[ARM],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let a = given.value(&ARM) / 3.0f64.sqrt();
        let corners = [[a, a, a], [a, -a, -a], [-a, a, -a], [-a, -a, a]];
        Ok(vec![corners.map(|corner| (corner, 0.5)).to_vec()])
    }
}
