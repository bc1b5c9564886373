//! Two grains on a prescribed path: the contact law by itself.

pub mod path;
pub mod refined;
#[cfg(test)]
mod small_steps;

pub use path::{PairError, PairRow, PathRow, drive_pair};
pub use refined::{RefinedPath, drive_pair_refined};
