//! The files in the folder of a deck.

/// Name of the script in the folder of a deck.
pub const SCRIPT: &str = "in.granum";
/// Name of the sample.
pub const DATA: &str = "packing.data";
/// Name of the curve that the script writes.
pub const CURVE: &str = "curve.csv";
