//! Prefetching of memory.

use granum_simd::LANES;

use super::source::ConstantSource;
use super::views::Views;

/// Number of batches between prefetching memory and using it.
pub(super) const AHEAD: usize = 5;

/// Prefetches what a later batch will read, and the lists that a later call of this function will read: the processor can
/// predict neither the indices of the grains nor the next page.
#[inline(always)]
pub(super) fn fetch_ahead<C: ConstantSource>(
    v: &Views,
    later: usize,
    lists: usize,
    columns: usize,
    constants: usize,
) {
    v.first.prefetch(lists);
    v.second.prefetch(lists);
    v.target.prefetch(lists);
    for c in 0..columns {
        v.memory.prefetch(later * columns + c);
    }
    if C::by_batch(v) {
        for c in 0..constants {
            v.constants.prefetch(later * constants + c);
        }
    }
    // SAFETY: lists are only read in this stage.
    let (first, second) = unsafe { (v.first.read(), v.second.read()) };
    if let (Some(i), Some(j)) = (first.get(later), second.get(later)) {
        for &grain in j.iter().chain(&i[LANES - 1..]) {
            v.particles.prefetch(grain as usize);
            v.spin.prefetch(grain as usize);
        }
    }
}

/// Number of rows of forces of the next block that are prefetched with every batch.
pub(super) const ROWS_AHEAD: usize = 4;

/// Indices of the rows of forces of the block after this one.
#[inline(always)]
pub(super) fn coming_rows(v: &Views, block: usize) -> impl Iterator<Item = u32> {
    // SAFETY: blocks are only read.
    let next = unsafe { v.blocks.read() }.get(block + 1).filter(|_| v.far).copied().unwrap_or_default();
    let [grains, outer] = [next.grains, next.outer];
    (grains[0]..grains[1]).chain(outer[0]..outer[1])
}
