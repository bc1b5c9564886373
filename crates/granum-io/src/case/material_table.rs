//! The tables `[[material]]` and `[[pair]]` of a case file as they were read.

use std::ops::Range;
use std::sync::Arc;

use super::field::{Field, Value};

/// Values of fields with the places of their keys.
pub(super) type Values = Vec<(Arc<Field>, Value, Range<usize>)>;

/// A table `[[material]]` as it is in the file.
pub(super) struct MaterialTable {
    pub(super) place: String,
    pub(super) span: Range<usize>,
    pub(super) name: String,
    pub(super) share: Option<(f64, Range<usize>)>,
    pub(super) values: Values,
}

/// A table `[[pair]]` as it is in the file.
pub(super) struct PairTable {
    pub(super) place: String,
    pub(super) between: [(String, Range<usize>); 2],
    pub(super) values: Values,
}
