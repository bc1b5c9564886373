//! Bonds as a checkpoint has them: laws by name, and numbers that must be possible before the kernels see them.

use super::bonds::Bonds;
use super::bonds::column::{COLUMNS, DASHPOTS, LIMIT};
use super::law::bond_law::LIMITS;
use super::law::kind::BondKind;
use crate::contact::choice::registry::{Laws, unknown};

/// More edges of the cell than any two pieces that a bond joins are apart.
const FARTHEST: i32 = 1 << 30;
/// More bonds than any run makes.
const MOST: u64 = 1 << 60;

impl Bonds {
    /// The names of its laws.
    pub(crate) fn law_names(&self) -> Vec<&'static str> {
        self.laws.iter().map(BondKind::name).collect()
    }

    /// The same with laws of these names.
    pub(crate) fn with_laws(mut self, names: &[String], laws: &Laws) -> Result<Bonds, String> {
        for name in names {
            let known = || laws.bonds().iter().map(BondKind::name);
            self.laws.push(laws.bond_named(name).ok_or_else(|| unknown("law of bonds", name, known()))?);
        }
        Ok(self)
    }

    /// True if its lists belong together, its indices are within a state of so many pieces, and its numbers are possible.
    pub(crate) fn are_consistent(&self, pieces: usize) -> bool {
        let batches = self.law.len();
        let oriented = if self.made == 0 { 0 } else { pieces };
        let lengths = self.ids.len() == batches
            && self.rows.len() == batches
            && self.columns.len() == batches * COLUMNS
            && self.images.len() == batches
            && self.dashpots.len() == batches * DASHPOTS
            && self.shapes.len() == 2 * batches
            && self.orientations.len() == oriented;
        lengths
            && self.made < MOST
            && self.fastest.is_finite()
            && self.law.iter().all(|law| (*law as usize) < self.laws.len())
            && self.rows.iter().flatten().flatten().all(|row| (*row as usize) < pieces.max(1))
            && self.orientations.iter().flat_map(|row| row.0).all(f64::is_finite)
            && self.shapes.iter().flat_map(|row| row.0).all(f64::is_finite)
            && self.columns.chunks(COLUMNS).all(are_possible)
            && self.images.iter().flatten().flatten().all(|edges| (-FARTHEST..FARTHEST).contains(edges))
            && self.dashpots.iter().flat_map(|row| row.0).all(f64::is_finite)
    }
}

/// True for the columns of a batch. Strengths may be infinite.
fn are_possible(columns: &[granum_simd::Row8]) -> bool {
    columns.iter().enumerate().all(|(k, row)| {
        row.0.iter().all(|x| match k {
            _ if (LIMIT..LIMIT + LIMITS).contains(&k) => !x.is_nan(),
            _ => x.is_finite(),
        })
    })
}
