//! A pair of pieces that a file lists as bonded.

use serde::{Deserialize, Serialize};

/// Two pieces that are to be bonded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListedPair {
    /// Their indices among the pieces of an assembly: body by body in the order of the ids.
    pub pieces: [usize; 2],
    /// Type of the bond, by which a set of bonds can choose.
    pub kind: u32,
}

impl ListedPair {
    /// True for two different pieces of so many.
    pub(crate) fn is_possible(&self, pieces: usize) -> bool {
        let [i, j] = self.pieces;
        i != j && i.max(j) < pieces
    }
}
