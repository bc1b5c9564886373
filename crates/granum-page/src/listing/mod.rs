//! What is in a folder: found by the names of files, which is quick, and told in a few words by their records.

mod found;
mod scan;
mod told;

pub use found::{Found, Kind};
pub use scan::{Scan, scan};
pub(crate) use told::{told, word};
