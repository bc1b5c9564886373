//! What the metadata of a file say: the units of its columns, and texts by keys.

use std::collections::BTreeMap;

use parquet::file::metadata::KeyValue;

/// Key of the units in the metadata of a file.
pub(super) const UNITS: &str = "granum.units";

/// Units written by granum; empty for files of other writers.
pub(super) fn units(metadata: Option<&Vec<KeyValue>>) -> BTreeMap<String, String> {
    let text = value(metadata, UNITS);
    text.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
}

/// The text of a key.
pub(super) fn value<'m>(metadata: Option<&'m Vec<KeyValue>>, key: &str) -> Option<&'m str> {
    metadata?.iter().find(|pair| pair.key == key)?.value.as_deref()
}
