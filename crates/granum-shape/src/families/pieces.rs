//! Spheres that are given as a list.

use crate::entry::ShapeEntry;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, Spheres};
use crate::union_of_spheres::connected::islands;

/// Spheres that are given as a list.
pub struct Pieces;

impl ShapeFamily for Pieces {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "pieces",
            help: "the spheres of the list `spheres`",
            parameters: &[],
            takes_spheres: true,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let spheres: Spheres =
            given.spheres.iter().map(|[x, y, z, radius]| ([*x, *y, *z], *radius)).collect();
        if spheres.is_empty() {
            let message = "is missing: kind = \"pieces\" needs a list of them, e.g. spheres = [[-0.5, 0, 0, 1], [0.5, 0, 0, 1]]";
            return Err(ShapeError::new("spheres", message));
        }
        if let Some(apart) = islands(&spheres) {
            let message = format!(
                "are two bodies: sphere {apart} does not touch those before it, directly or by others"
            );
            return Err(ShapeError::new("spheres", message));
        }
        Ok(vec![spheres])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::ShapeKind;

    #[test]
    fn two_bodies_and_equal_spheres_are_refused() {
        let entry = |spheres: &[[f64; 4]]| ShapeEntry {
            spheres: spheres.to_vec(),
            ..ShapeEntry::new(ShapeKind::PIECES)
        };
        let said = |spheres: &[[f64; 4]]| entry(spheres).shapes().unwrap_err().to_string();
        assert!(said(&[[0.0, 0.0, 0.0, 1.0], [3.0, 0.0, 0.0, 0.5]]).contains("sphere 1 does not touch"));
        assert!(said(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]).contains("are equal"));
        assert!(said(&[[0.0, 0.0, 0.0, -1.0]]).contains("must be positive"));
        assert_eq!(entry(&[[0.0, 0.0, 0.0, 1.0], [1.5, 0.0, 0.0, 0.5]]).shapes().unwrap().len(), 1);
    }
}
