//! Apache Parquet: flat columns of numbers and of words, and columns of lists of numbers ([`ListColumn`]).
//!
//! Files are written uncompressed and plain (measured numbers do not compress), one `DOUBLE` column each (`INT64`,
//! `BOOLEAN` or UTF-8 text for columns of that [`ColumnKind`](granum_core::ColumnKind)), with units as key-value metadata `granum.units`
//! (JSON), and further metadata that are given, as the cell of grains and contacts (`granum.cell`). Nothing in the file depends on time or machine: equal tables give equal bytes. Flat columns of booleans, integers and floating-point
//! numbers are read from files of any writer, uncompressed or with snappy or gzip; a null becomes NaN. Sizes given in the file are
//! checked against the size of the file before memory is allocated for them.

mod decoding;
mod format;
mod lists;
mod metadata;
mod reading;
mod sizes;
mod thrift;
mod words;
mod writing;

use std::path::Path;

use granum_core::Table;

pub use self::lists::{ListColumn, TableWithLists};
pub use self::reading::{read, read_bytes, read_metadata, read_with_lists, read_with_words};
pub use self::writing::{write, write_groups, write_parts, write_with_lists, write_with_metadata};
use crate::error::Result;
use crate::formats::TableFormat;

/// The format.
pub struct Parquet;

impl TableFormat for Parquet {
    fn name(&self) -> &'static str {
        "Parquet"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["parquet"]
    }
    fn read(&self, path: &Path, names: Option<&[&str]>) -> Result<Table> {
        read(path, names)
    }
    fn read_with_words(&self, path: &Path, names: Option<&[&str]>) -> Result<Table> {
        read_with_words(path, names)
    }
    fn write(&self, path: &Path, table: &Table) -> Result<()> {
        write(path, table)
    }
    fn write_with_metadata(&self, path: &Path, table: &Table, metadata: &[(&str, String)]) -> Result<()> {
        write_with_metadata(path, table, metadata)
    }
}

#[cfg(test)]
mod tests;
