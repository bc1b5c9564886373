//! The first stage of bonds in a step: the pieces that have bonds turn with their spins, eight at a time, or take the orientations of
//! their bodies.

use std::ops::Range;

use granum_simd::{Kernel, LANES, Lanes, Row4, Row8};

use super::motion::turned;
use super::views::PIECES;
use crate::clump::clumps::NO_CLUMP;
use crate::kernel::Views;

/// The stage for a range of blocks of pieces that have bonds.
pub(crate) struct TurningStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl Kernel for TurningStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        // SAFETY: the list is never written in a step.
        let bonded = unsafe { v.bonds.bonded.read() };
        let range = self.blocks.start * PIECES..usize::min(self.blocks.end * PIECES, bonded.len());
        let eights = bonded.get(range).unwrap_or_default().chunks_exact(LANES);
        let rest = eights.remainder();
        for eight in eights {
            let mut rows = [0; LANES];
            rows.copy_from_slice(eight);
            turn::<L>(v, &rows, LANES);
        }
        if !rest.is_empty() {
            let mut rows = [rest[0]; LANES];
            rows[..rest.len()].copy_from_slice(rest);
            turn::<L>(v, &rows, rest.len());
        }
    }
}

/// Turns the first of eight pieces.
#[inline(always)]
fn turn<L: Lanes>(v: &Views, rows: &[u32; LANES], count: usize) {
    // SAFETY: a piece is in the list once, and its block belongs to one thread; spins and bodies are only read.
    let (spin, orientations) = unsafe { (v.spin.read(), v.bonds.orientations.read()) };
    let (w, q) = (L::gather4(spin, rows), L::gather4(orientations, rows));
    let [a, b, c, d] = turned(&q, &[w[0], w[1], w[2]], L::splat(v.dt));
    let (zero, mut after) = (L::zero(), [Row8::default(); LANES]);
    L::scatter8([a, b, c, d, zero, zero, zero, zero], &mut after);
    for lane in 0..count {
        let (row, Row8([w, x, y, z, ..])) = (rows[lane] as usize, after[lane]);
        // SAFETY: as above.
        let orientation = unsafe { &mut v.bonds.orientations.write(row..row + 1)[0] };
        *orientation = of_body(v, row).unwrap_or(Row4([w, x, y, z]));
    }
}

/// The orientation of the body of a piece, where it has several pieces.
#[inline(always)]
fn of_body(v: &Views, row: usize) -> Option<Row4> {
    if v.clump_of.len() == 0 {
        return None;
    }
    // SAFETY: bodies were moved before this stage, and are only read in it.
    let (clump, clumps) = unsafe { (v.clump_of.read()[row], v.clumps.read()) };
    (clump != NO_CLUMP).then(|| Row4(clumps[clump as usize].orientation))
}
