//! The columns of a CSV file that a reader asks for.

use std::collections::HashSet;

use crate::error::Result;
use crate::sheet::{Sheet, Sought};

/// Reads what has a header with these names, or any if there are none.
pub(super) fn with_header<T>(names: Option<&[&str]>, read: impl FnOnce(&Sought) -> Result<T>) -> Result<T> {
    let Some(names) = names.filter(|names| !names.is_empty()) else { return read(&Sought::NOTHING) };
    let set: HashSet<&str> = names.iter().copied().collect();
    read(&Sought { is_name: &|cell| set.contains(cell), count: set.len(), may_have_units: false })
}

/// The columns of these names, or all.
pub(super) fn wanted(sheet: &Sheet, names: Option<&[&str]>) -> Result<Vec<usize>> {
    match names {
        None => Ok((0..sheet.header().len()).collect()),
        Some(names) => names.iter().map(|name| sheet.position(name)).collect(),
    }
}
