//! Access of all threads to the state during the stages of a step.

use granum_simd::{Isa, LANES, Row4, Row8};

use crate::assembly::Matrix;
use crate::bond::BondViews;
use crate::clump::clumps::Clump;
use crate::clump::ranks::Rank;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact_sums::ContactSums;
use crate::images::IMAGES;
use crate::inner_list::Nearness;
use crate::pairs::{Block, Marks};
use crate::team::RawSlice;

/// The arrays of the state that the threads share during the stages of a step.
#[derive(Clone, Copy)]
pub(crate) struct Views {
    pub(crate) grains: usize,
    pub(crate) particles: RawSlice<Row8>,
    pub(crate) spin: RawSlice<Row4>,
    pub(crate) blocks: RawSlice<Block>,
    pub(crate) first: RawSlice<[u32; LANES]>,
    pub(crate) second: RawSlice<[u32; LANES]>,
    pub(crate) target: RawSlice<[u32; LANES]>,
    pub(crate) image: RawSlice<[u32; LANES]>,
    pub(crate) memory: RawSlice<Row8>,
    /// Volumes of the films of grains; empty if no law shares liquid.
    pub(crate) films: RawSlice<f64>,
    pub(crate) marks: RawSlice<Marks>,
    /// Working memory of the pruning stage.
    pub(crate) nearness: RawSlice<Nearness>,
    /// Number of columns of a contact history.
    pub(crate) columns: usize,
    pub(crate) constants: RawSlice<Row8>,
    pub(crate) forces: RawSlice<Row8>,
    pub(crate) outer_offsets: RawSlice<u32>,
    pub(crate) outer: RawSlice<u32>,
    pub(crate) contact_sums: RawSlice<ContactSums>,
    pub(crate) fastest_grain: RawSlice<f64>,
    /// Clumps and their pieces; empty without clumps, as are the next two.
    pub(crate) clumps: RawSlice<Clump>,
    pub(crate) ranks: RawSlice<Rank>,
    /// The ranks of each eight clumps.
    pub(crate) ranks_of_eight: RawSlice<[u32; 2]>,
    /// The clump of each row.
    pub(crate) clump_of: RawSlice<u32>,
    /// The arm of each row from the centre of its body, m.
    pub(crate) arms: RawSlice<Row4>,
    /// Bonds; empty without bonds.
    pub(crate) bonds: BondViews,
    /// True where all grains have the same mass and radius.
    pub(crate) equal: bool,
    /// True where the contact data do not fit into the caches.
    pub(crate) far: bool,
    pub(crate) alike: PairConstants<f64>,
    /// Number of rows of constants of a batch.
    pub(crate) constants_kept: usize,
    pub(crate) laws: ContactModel,
    pub(crate) isa: Isa,
    pub(crate) images: [Row4; IMAGES],
    pub(crate) gradient: Matrix,
    /// Edges of the cell, m.
    pub(crate) edges: Matrix,
    pub(crate) dt: f64,
    /// Pairs with a gap below this belong to the inner list, m.
    pub(crate) inner_skin: f64,
    /// Largest distance of the surfaces at which grains that do not touch begin to interact, m.
    pub(crate) onset: f64,
    /// Weight of the energy of discarded histories in this step; zero where it is not evaluated.
    pub(crate) sampling_weight: f64,
    /// Factor on velocities and spins in a step: 1 without global damping.
    pub(crate) retain: f64,
}
