//! A row of a table of contacts beside the geometry of its grains.

use granum_core::assembly::{Assembly, Vector};
use granum_core::geometry::dot;

use crate::formats::result::FileContact;

/// A row and what the places of its grains say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Number of the row in the table, from 0.
    pub(super) number: usize,
    pub(super) pair: FileContact,
    /// The places of its grains in the list of grains.
    pub(super) grains: [usize; 2],
    /// Vector from the centre of the first to that of the second grain, m.
    pub(super) branch: Vector,
    /// Sum of the radii, m; none where radii are not known.
    pub(super) radii: Option<f64>,
}

impl Row {
    /// Distance of the surfaces, m: negative where the grains overlap; none where radii are not known.
    pub(super) fn gap(&self) -> Option<f64> {
        self.radii.map(|radii| dot(&self.branch, &self.branch).sqrt() - radii)
    }

    /// Normal force, compression positive, and tangential force on the first grain, as far as the row has them.
    pub(super) fn forces(&self) -> (Option<f64>, Option<Vector>) {
        let length = dot(&self.branch, &self.branch).sqrt();
        let normal = self.pair.normal.unwrap_or_else(|| self.branch.map(|x| x / length));
        self.pair.forces(&normal)
    }

    /// True if the row says that there is no force.
    pub(super) fn is_without_force(&self) -> bool {
        let (normal, tangential) = self.forces();
        normal == Some(0.0) && tangential.is_none_or(|force| force == [0.0; 3])
    }

    /// True if the row says something of a force.
    pub(super) fn has_force(&self) -> bool {
        let (normal, tangential) = self.forces();
        normal.is_some() || tangential.is_some()
    }

    /// The contact with its branch.
    pub(super) fn with_branch(&self) -> FileContact {
        FileContact { branch: Some(self.branch), ..self.pair }
    }

    /// "the grains 3 and 7"
    pub(super) fn of_grains(&self) -> String {
        format!("the grains {} and {}", self.pair.first, self.pair.second)
    }
}

/// Sum of the radii of two grains, m.
pub(super) fn radii_of(assembly: &Assembly, grains: [usize; 2]) -> f64 {
    let [one, two] = grains.map(|grain| assembly.pieces[grain].radius);
    one + two
}
