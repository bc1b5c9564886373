//! The loads of bonds are added to the forces on their pieces, for each piece in the order of the batches and of the bonds in them. One thread
//! alone does so as soon as a batch is loaded. Several threads leave the loads of all bonds in memory, and every piece then adds up those in
//! its list of ends; the sums have the same bits.

use std::ops::Range;

use granum_simd::{Kernel, LANES, Lanes, Row8};

use super::motion::Vectors;
use super::views::{LOADS, PIECES};
use crate::kernel::Views;

/// Number of ends between prefetching one and adding it, and of those that are prefetched for each piece.
const AHEAD: usize = 32;
const ENDS_A_PIECE: usize = 6;

/// What eight bonds do to their pieces.
pub(super) struct Loads<L> {
    /// Force on the first ends, N; that on the second is opposite.
    pub(super) force: Vectors<L>,
    /// Torques on the first and on the second ends over the radii of their pieces, N.
    pub(super) torques: [Vectors<L>; 2],
}

impl<L: Lanes> Loads<L> {
    /// Those of bonds that are all gone.
    #[inline(always)]
    pub(super) fn none() -> Loads<L> {
        let zero = [L::zero(); 3];
        Loads { force: zero, torques: [zero; 2] }
    }

    /// Leaves the loads in memory.
    #[inline(always)]
    pub(super) fn put(&self, columns: &mut [Row8]) {
        for k in 0..3 {
            self.force[k].store(&mut columns[k].0);
            self.torques[0][k].store(&mut columns[3 + k].0);
            self.torques[1][k].store(&mut columns[6 + k].0);
        }
    }

    /// Adds the loads to the forces on the pieces.
    ///
    /// # Safety
    /// No other thread works on the stage.
    #[inline(always)]
    pub(super) unsafe fn add(&self, v: &Views, rows: &[[u32; LANES]; 2]) {
        // To add a negative zero changes no bit.
        let ([x, y, z], none) = (self.force, L::splat(-0.0));
        let ([a, b, c], [d, e, f]) = (self.torques[0], self.torques[1]);
        let first = L::transpose([x, y, z, none, a, b, c, none]);
        let second = L::transpose([-x, -y, -z, none, d, e, f, none]);
        for lane in 0..LANES {
            let [i, j] = [rows[0][lane], rows[1][lane]];
            // A lane without a bond joins a piece with itself.
            if i != j {
                for (row, load) in [(i as usize, first[lane]), (j as usize, second[lane])] {
                    // SAFETY: the caller works alone, and the reference ends here.
                    let force = unsafe { &mut v.forces.write(row..row + 1)[0].0 };
                    (L::load(force) + load).store(force);
                }
            }
        }
    }
}

/// The stage of pieces that have bonds, for a range of blocks: adds up the loads of their bonds.
pub(crate) struct BondedStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl Kernel for BondedStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        // SAFETY: lists and loads are only read in this stage.
        let (bonded, offsets, ends, loads) = unsafe {
            (v.bonds.bonded.read(), v.bonds.offsets.read(), v.bonds.ends.read(), v.bonds.loads.read())
        };
        for k in self.blocks {
            for place in k * PIECES..usize::min((k + 1) * PIECES, bonded.len()) {
                let row = bonded[place] as usize;
                let fetched = if v.bonds.far { ENDS_A_PIECE } else { 0 };
                for later in ends.iter().skip(offsets[place] as usize + AHEAD).take(fetched) {
                    let (batch, side) = (*later as usize / (2 * LANES), *later as usize % 2);
                    for k in 0..3 {
                        v.bonds.loads.prefetch(LOADS * batch + k);
                        v.bonds.loads.prefetch(LOADS * batch + 3 + 3 * side + k);
                    }
                }
                // SAFETY: a piece is in the list once, and its block belongs to one thread.
                let force = unsafe { &mut v.forces.write(row..row + 1)[0] };
                let mut sum = force.0;
                for end in &ends[offsets[place] as usize..offsets[place + 1] as usize] {
                    add(&mut sum, loads, *end as usize);
                }
                force.0 = sum;
            }
        }
    }
}

/// Adds the load of an end, with the number of [`super::ends::EndLists`]: the force on the second is opposite.
#[inline(always)]
fn add(sum: &mut [f64; 8], loads: &[Row8], end: usize) {
    let (batch, lane, side) = (end / (2 * LANES), end / 2 % LANES, end % 2);
    let Some(loads) = loads.get(LOADS * batch..LOADS * (batch + 1)) else { return };
    let sign = 1.0 - 2.0 * side as f64;
    for k in 0..3 {
        sum[k] += sign * loads[k].0[lane];
        sum[4 + k] += loads[3 + 3 * side + k].0[lane];
    }
}
