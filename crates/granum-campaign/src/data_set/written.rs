//! What was written of a data set, for its card and its metadata.

use std::collections::BTreeMap;

use granum_io::Table;
use granum_io::formats::parquet::TableWithLists;

use super::contents::Contents;
use crate::campaign::Campaign;

/// What a data set has, for its card and its metadata.
pub(super) struct Written<'a> {
    pub campaign: &'a Campaign,
    pub contents: &'a Contents,
    pub runs: &'a Table,
    /// The columns of the states, without rows.
    pub states: &'a TableWithLists,
    /// Number of states.
    pub rows: usize,
    /// SHA-256 of the files of runs and states.
    pub sums: &'a BTreeMap<&'static str, String>,
    /// SHA-256 over the content.
    pub digest: &'a str,
}
