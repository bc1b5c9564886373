//! A table of contacts and the grains beside it, as every check sees them.

use granum_core::assembly::Assembly;
use granum_core::{Part, Parts};

use super::options::ContactOptions;
use super::row::Row;
use crate::packing::Implausible;
use crate::packing::lattice::Images;

/// A table of contacts, and what it is held against.
pub(crate) struct ContactTable<'a> {
    /// The grains, in their cell.
    pub(crate) assembly: &'a Assembly,
    /// What of them is known.
    pub(crate) parts: Parts,
    /// The images of the cell.
    pub(crate) images: Images,
    /// Largest error of a distance by the rounding of the numbers, m.
    pub(crate) rounding: f64,
    /// The body of each grain that is part of one with others, by the place of the grain.
    pub(crate) body_of: &'a dyn Fn(usize) -> Option<u64>,
    /// Answers to what cannot be decided.
    pub(crate) options: ContactOptions,
}

/// The rows that count after a check.
pub(super) type Outcome = Result<Vec<Row>, Implausible>;

impl ContactTable<'_> {
    /// True if the grains are in a periodic cell.
    pub(super) fn has_cell(&self) -> bool {
        self.parts.has(Part::Cell)
    }
}

/// "1 pair" or "3 pairs".
pub(super) fn count_of(count: usize, one: &str, several: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {several}") }
}
