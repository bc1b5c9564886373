//! What a format of tables provides.

use std::path::Path;

use granum_core::Table;

use crate::error::Result;

/// A format of tables of numbers.
pub trait TableFormat: Send + Sync {
    /// Its name, e.g. "Parquet".
    fn name(&self) -> &'static str;
    /// The extensions of its files, in lower case and without the dot.
    fn extensions(&self) -> &'static [&'static str];
    /// Reads the named columns in the requested order, or all numeric ones.
    ///
    /// # Errors
    /// If the file cannot be read or is not of this format; if a column is missing, with the nearest name.
    fn read(&self, path: &Path, names: Option<&[&str]>) -> Result<Table>;
    /// Reads the named columns of a file, in that order, or all, with those that hold text as columns of words. A format that knows
    /// numbers only reads these.
    ///
    /// # Errors
    /// As [`TableFormat::read`].
    fn read_with_words(&self, path: &Path, names: Option<&[&str]>) -> Result<Table> {
        self.read(path, names)
    }
    /// Writes a table under a temporary name and renames it. Equal tables give equal bytes.
    ///
    /// # Errors
    /// If the table cannot be represented in this format, or the file cannot be written.
    fn write(&self, path: &Path, table: &Table) -> Result<()>;
    /// Writes a table with metadata, keys with texts, in a format that has a place for them; others write the table alone.
    ///
    /// # Errors
    /// As [`TableFormat::write`].
    fn write_with_metadata(&self, path: &Path, table: &Table, metadata: &[(&str, String)]) -> Result<()> {
        let _ = metadata;
        self.write(path, table)
    }
}
