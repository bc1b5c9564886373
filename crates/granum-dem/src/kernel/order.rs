//! The order in which the contact stage evaluates the batches of a block.

use crate::pairs::Block;

/// The order in which the batches of a block are evaluated.
pub(super) struct Order {
    /// First batch within the cell, first batch with images, first batch of the next block.
    pub(super) first: [usize; 3],
    /// Number of batches within the cell, and how many of them, from the first, had a contact in every lane when the pairs
    /// were last sorted.
    pub(super) within: usize,
    pub(super) touching: usize,
    /// Number of batches.
    pub(super) count: usize,
}

impl Order {
    #[inline(always)]
    pub(super) fn new(block: &Block) -> Order {
        let first = block.batches.map(|b| b as usize);
        let [within, across] = [0, 1].map(|zone| block.inner_ends[zone] as usize - first[zone]);
        Order { first, within, touching: block.touching as usize, count: within + across }
    }

    /// The batch at a position of the order; positions beyond the last give batches of the next block.
    #[inline(always)]
    pub(super) fn batch(&self, turn: usize) -> usize {
        let [within, across, next] = self.first;
        if turn < self.within {
            within + turn
        } else if turn < self.count {
            across + (turn - self.within)
        } else {
            next + (turn - self.count)
        }
    }
}
