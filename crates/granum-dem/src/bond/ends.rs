//! Which ends of bonds are on which piece: the lists with which the forces of bonds are added up, in a fixed order.

use granum_simd::LANES;

use super::bonds::Bonds;

/// The ends of bonds by piece. End `16 b + 2 l + s` is that on side s of the bond in lane l of batch b.
#[derive(Clone, Debug, Default)]
pub(crate) struct EndLists {
    /// Rows of the pieces that have bonds, rising.
    pub(super) bonded: Vec<u32>,
    /// The ends of the k-th of them are `ends[offsets[k]..offsets[k + 1]]`.
    pub(super) offsets: Vec<u32>,
    pub(super) ends: Vec<u32>,
}

impl EndLists {
    /// The lists of these bonds, those included that ruptured since they were packed: their loads are zero.
    pub(crate) fn new(bonds: &Bonds) -> EndLists {
        let mut all: Vec<[u32; 2]> = Vec::with_capacity(2 * LANES * bonds.batches());
        for batch in 0..bonds.batches() {
            for lane in (0..LANES).filter(|lane| bonds.is_filled(batch, *lane)) {
                for side in 0..2 {
                    let end = (2 * LANES * batch + 2 * lane + side) as u32;
                    all.push([bonds.rows[batch][side][lane], end]);
                }
            }
        }
        all.sort_unstable();
        let mut lists = EndLists::default();
        for of_row in all.chunk_by(|a, b| a[0] == b[0]) {
            lists.bonded.push(of_row[0][0]);
            lists.offsets.push(lists.ends.len() as u32);
            lists.ends.extend(of_row.iter().map(|end| end[1]));
        }
        lists.offsets.push(lists.ends.len() as u32);
        lists
    }
}
