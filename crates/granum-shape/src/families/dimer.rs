//! Two equal spheres.

use crate::entry::ShapeEntry;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};

/// Two equal spheres whose centres are apart by a share of their diameter.
pub struct Dimer;

const SEPARATION: ShapeParameter = ShapeParameter {
    key: "separation",
    default: 0.5,
    bounds: [0.01, 1.0],
    whole: false,
    meaning: "Distance of the centres of the two spheres over their diameter.",
};

impl ShapeFamily for Dimer {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "dimer",
            help: "two equal spheres",
            parameters: &[SEPARATION],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let half = 0.5 * given.value(&SEPARATION);
        Ok(vec![vec![([-half, 0.0, 0.0], 0.5), ([half, 0.0, 0.0], 0.5)]])
    }
}
