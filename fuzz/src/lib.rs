//! What the fuzz targets do, and what they start from.

pub mod checks;
pub mod seeds;
