//! Tables of contacts held against the grains that stand beside them.
//!
//! Programs list what their neighbour lists contain, each pair in both directions, forces on the second grain, or only some of the
//! pairs. What is certain is set right and said: pairs that do not touch and have no force, repeated pairs, normals and branches from the
//! second grain to the first. A force across a gap, as of a bridge of liquid or of adhesion, counts and is named. What cannot be decided is refused,
//! with the [option](ContactOptions) that decides it. Differences below the rounding of the file's numbers say nothing.

mod apart;
mod branches;
mod missing;
mod options;
mod repeated;
mod row;
mod signs;
mod table;
#[cfg(test)]
mod tests;

use granum_core::Part;

use self::row::{Row, radii_of};
use super::remark::Remark;
use super::result::FileContact;
use crate::packing::Implausible;

pub(super) use table::ContactTable;

pub use options::{ContactForces, ContactOptions, MissingPairs, PairsApart, RepeatedPairs};

/// The rows that count, each with the places of its grains in their list, and what was set right or is doubtful.
pub(super) struct Held {
    pub(super) pairs: Vec<FileContact>,
    pub(super) places: Vec<[usize; 2]>,
    pub(super) remarks: Vec<Remark>,
}

impl ContactTable<'_> {
    /// Holds rows, each with the places of its grains in their list, against the grains.
    ///
    /// # Errors
    /// For what cannot be decided, with the option that decides it.
    pub(super) fn hold(&self, pairs: Vec<FileContact>, places: Vec<[usize; 2]>) -> Result<Held, Implausible> {
        let mut remarks = Vec::new();
        let rows: Vec<Row> = pairs.into_iter().zip(places).enumerate().map(|row| self.row(row)).collect();
        let rows = branches::check(self, rows, &mut remarks)?;
        let rows = repeated::check(self, rows, &mut remarks)?;
        let rows = apart::check(self, rows, &mut remarks)?;
        let rows = signs::check(self, rows, &mut remarks)?;
        let rows = missing::check(self, rows, &mut remarks)?;
        let (pairs, places) = rows.into_iter().map(|row| (row.with_branch(), row.grains)).unzip();
        Ok(Held { pairs, places, remarks })
    }

    fn row(&self, (number, (pair, grains)): (usize, (FileContact, [usize; 2]))) -> Row {
        let [one, two] = grains.map(|grain| self.assembly.bodies[grain].position);
        let branch = self.images.nearest(std::array::from_fn(|a| two[a] - one[a]));
        let radii = self.parts.has(Part::Radii).then(|| radii_of(self.assembly, grains));
        Row { number, pair, grains, branch, radii }
    }
}
