//! The working memory of bonds, which follows from the state.

use granum_simd::Row8;

use super::bonds::Bonds;
use super::ends::EndLists;
use super::guard::guards_of;
use super::law::bond_law::Criterion;
use super::views::{BATCHES, BondSums, BondViews, LOADS, Ruptures};
use crate::team::RawSlice;

/// From this size of the bonds on, in bytes, what they need is prefetched.
const FAR: usize = 4 << 20;

/// What the bonds of a simulation need to be computed; all of it follows from the state.
#[derive(Clone, Default)]
pub(crate) struct BondWork {
    pub(super) lists: EndLists,
    pub(super) loads: Vec<Row8>,
    pub(super) sums: Vec<BondSums>,
    pub(super) ruptures: Vec<Ruptures>,
    criteria: Vec<Criterion>,
    guards: Vec<Row8>,
}

impl BondWork {
    /// The work of these bonds.
    pub(crate) fn new(bonds: &Bonds) -> BondWork {
        let batches = bonds.batches();
        BondWork {
            lists: EndLists::new(bonds),
            loads: vec![Row8::default(); LOADS * batches],
            sums: vec![BondSums::default(); batches.div_ceil(BATCHES)],
            ruptures: vec![Ruptures::default(); batches],
            guards: (0..batches).map(|batch| guards_of(bonds, batch)).collect(),
            criteria: bonds.laws.iter().map(|kind| kind.law().criterion()).collect(),
        }
    }

    /// The views of its arrays and of the bonds.
    pub(crate) fn views(&mut self, bonds: &mut Bonds) -> BondViews {
        BondViews {
            damped: bonds.is_damped(),
            far: size_of_val(&bonds.columns[..]) > FAR,
            law: RawSlice::new(&mut bonds.law),
            laws: RawSlice::new(&mut bonds.laws),
            criteria: RawSlice::new(&mut self.criteria),
            guards: RawSlice::new(&mut self.guards),
            rows: RawSlice::new(&mut bonds.rows),
            columns: RawSlice::new(&mut bonds.columns),
            images: RawSlice::new(&mut bonds.images),
            dashpots: RawSlice::new(&mut bonds.dashpots),
            orientations: RawSlice::new(&mut bonds.orientations),
            loads: RawSlice::new(&mut self.loads),
            sums: RawSlice::new(&mut self.sums),
            ruptures: RawSlice::new(&mut self.ruptures),
            bonded: RawSlice::new(&mut self.lists.bonded),
            offsets: RawSlice::new(&mut self.lists.offsets),
            ends: RawSlice::new(&mut self.lists.ends),
        }
    }
}
