//! What the stages of bonds read and write.

use granum_simd::{LANES, Row4, Row8};

use super::law::bond_law::{Criterion, Eight};
use super::law::kind::BondKind;
use crate::team::RawSlice;

/// Batches of bonds in a block, the unit of work of a thread.
pub(crate) const BATCHES: usize = 8;
/// Columns of the loads of a batch: the force on the first ends, and the torques over radius on the first and on the second.
pub(crate) const LOADS: usize = 9;
/// Pieces in a block of the second stage.
pub(crate) const PIECES: usize = 64;

/// Sums over the bonds of a block.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct BondSums {
    /// `- sum of (elastic force on i)_a (branch)_b`, J.
    pub(crate) virial: [f64; 9],
    /// Power that the deformation of the cell supplies, W.
    pub(crate) power: f64,
    /// Lost in dashpots in this step, J.
    pub(crate) damping: f64,
    /// Energy of the bonds that ruptured by tension, and by shear, J.
    pub(crate) broken: [f64; 2],
    /// `sum of k_n A D^2`, J.
    pub(crate) stiffness: f64,
    /// `sum of |N|`, N.
    pub(crate) normal_force: f64,
    /// True if a bond ruptured.
    pub(crate) ruptured: bool,
}

/// The bonds of a batch that ruptured in this step: one bit for each, by tension and by shear, and their energies, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ruptures {
    pub(crate) tension: u8,
    pub(crate) shear: u8,
    pub(crate) energy: Eight,
}

/// What the stages of bonds read and write.
#[derive(Clone, Copy)]
pub(crate) struct BondViews {
    pub(crate) law: RawSlice<u8>,
    pub(crate) laws: RawSlice<BondKind>,
    /// What each law answers when it is asked for its criterion: in the stage a call would cost more than the criterion.
    pub(crate) criteria: RawSlice<Criterion>,
    pub(crate) rows: RawSlice<[[u32; LANES]; 2]>,
    pub(crate) columns: RawSlice<Row8>,
    /// [`super::guard`] of each batch.
    pub(crate) guards: RawSlice<Row8>,
    /// Edges of the cell between the first piece of each and the image of the second.
    pub(crate) images: RawSlice<[[i32; LANES]; 3]>,
    pub(crate) dashpots: RawSlice<Row8>,
    pub(crate) orientations: RawSlice<Row4>,
    /// Force and torques over radius, [`LOADS`] columns a batch.
    pub(crate) loads: RawSlice<Row8>,
    pub(crate) sums: RawSlice<BondSums>,
    pub(crate) ruptures: RawSlice<Ruptures>,
    pub(crate) bonded: RawSlice<u32>,
    pub(crate) offsets: RawSlice<u32>,
    pub(crate) ends: RawSlice<u32>,
    /// True if any bond has dashpots.
    pub(crate) damped: bool,
    /// True where the bonds do not fit into the caches.
    pub(crate) far: bool,
}

impl BondViews {
    /// Number of blocks of bonds, and of pieces that have bonds.
    pub(crate) fn blocks(&self) -> [usize; 2] {
        [self.law.len().div_ceil(BATCHES), self.bonded.len().div_ceil(PIECES)]
    }
}
