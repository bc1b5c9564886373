//! The units of the columns of a file.

use std::collections::BTreeMap;

use parquet::file::metadata::KeyValue;

/// Key of the units in the metadata of a file.
pub(super) const UNITS: &str = "granum.units";

/// Units written by granum; empty for files of other writers.
pub(super) fn units(metadata: Option<&Vec<KeyValue>>) -> BTreeMap<String, String> {
    let text = metadata.and_then(|all| all.iter().find(|pair| pair.key == UNITS)?.value.clone());
    text.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}
