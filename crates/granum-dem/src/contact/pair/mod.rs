//! Two grains on a prescribed path: the contact law by itself.

pub mod path;
pub mod refined;

pub use path::{PairError, PairRow, PathRow, drive_pair};
pub use refined::{RefinedPath, drive_pair_refined};
