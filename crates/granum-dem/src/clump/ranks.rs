//! The pieces of eight clumps at a time, rank by rank: the first piece of each, the second of each, and so on. They are arranged once a
//! neighbour list, so that the stage of clumps loads eight numbers at once.

use granum_simd::LANES;

use super::clumps::Clumps;

/// The pieces of one rank of up to eight clumps.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Rank {
    /// Centres in the axes of the bodies, m.
    pub(crate) centre: [[f64; LANES]; 3],
    /// Radii, m.
    pub(crate) radius: [f64; LANES],
    /// The rows of the pieces.
    pub(crate) rows: [u32; LANES],
    /// False where a lane has no clump, or its clump no piece of this rank.
    pub(crate) present: [bool; LANES],
    /// True if a row is in another image than its body.
    pub(crate) imaged: bool,
    /// Edges of the cell from the image of a body to that of its row.
    pub(crate) images: [[i32; 3]; LANES],
}

/// The ranks of all clumps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ranks {
    pub(crate) ranks: Vec<Rank>,
    /// The ranks of each eight clumps: the first, and one past the last.
    pub(crate) of_eight: Vec<[u32; 2]>,
}

impl Ranks {
    pub(crate) fn new(clumps: &Clumps) -> Ranks {
        let mut all = Ranks::default();
        for eight in clumps.bodies.chunks(LANES) {
            let most = eight.iter().map(|clump| clumps.pieces_of(clump).len()).fold(0, usize::max);
            let first = all.ranks.len() as u32;
            for k in 0..most {
                let mut rank = Rank {
                    centre: [[0.0; LANES]; 3],
                    radius: [0.0; LANES],
                    rows: [0; LANES],
                    present: [false; LANES],
                    imaged: false,
                    images: [[0; 3]; LANES],
                };
                for (l, clump) in eight.iter().enumerate() {
                    let Some(piece) = clumps.pieces_of(clump).get(k) else { continue };
                    for a in 0..3 {
                        rank.centre[a][l] = piece.centre[a];
                    }
                    (rank.radius[l], rank.rows[l], rank.present[l]) = (piece.radius, piece.row, true);
                    rank.images[l] = piece.image;
                    rank.imaged |= piece.image != [0; 3];
                }
                all.ranks.push(rank);
            }
            all.of_eight.push([first, all.ranks.len() as u32]);
        }
        all
    }
}
