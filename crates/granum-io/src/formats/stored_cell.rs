//! The periodic cell of grains or contacts in the metadata of a table: `granum.cell`, a text of JSON with `origin` and with `edges`, whose
//! column k is edge k, in m.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::parquet;
use super::result::FrameCell;
use crate::error::{Error, Result};

/// Key of the cell.
pub(super) const CELL: &str = "granum.cell";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredCell {
    origin: [f64; 3],
    edges: [[f64; 3]; 3],
}

/// The text of a cell.
///
/// # Errors
/// If it cannot be written as JSON.
pub(super) fn cell_text(path: &Path, cell: &FrameCell) -> Result<String> {
    let stored = StoredCell { origin: cell.origin, edges: cell.edges };
    serde_json::to_string(&stored).map_err(|error| Error::content(path, error.to_string()))
}

/// The cell that granum wrote into a Parquet file; none for files of other writers.
///
/// # Errors
/// As [`parquet::read_metadata`], and if what is there is no cell.
pub(super) fn read_cell(path: &Path) -> Result<Option<FrameCell>> {
    let Some(text) = parquet::read_metadata(path, CELL)? else { return Ok(None) };
    let wrong = |error| Error::content(path, format!("its metadata {CELL} are no cell: {error}"));
    let StoredCell { origin, edges } = serde_json::from_str(&text).map_err(wrong)?;
    Ok(Some(FrameCell { origin, edges }))
}
