//! A pair of spheres that a packing lists as bonded.

/// Two spheres of a packing that are bonded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PackedBond {
    /// Their places among all spheres, grain by grain and piece by piece, from 0.
    pub pieces: [usize; 2],
    /// Type of the bond in the file, from 1.
    pub kind: u32,
}
