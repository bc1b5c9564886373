//! A table `[[grains.shape]]` of a case file as it was read.

use std::ops::Range;

use super::material_table::Values;

/// A table `[[grains.shape]]` as it is in the file.
pub(super) struct ShapeTable {
    pub(super) place: String,
    pub(super) span: Range<usize>,
    pub(super) values: Values,
    pub(super) share: Option<f64>,
    pub(super) material: Option<String>,
    pub(super) limits: [Option<f64>; 2],
    pub(super) file: Option<(String, Range<usize>)>,
}
