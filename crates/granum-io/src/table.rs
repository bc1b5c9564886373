//! Tables in files: the format is told by the extension of the file's name.

use std::path::Path;

use granum_core::Table;

use crate::error::{Error, Result};

/// The table formats, told by the extension of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Comma-separated values, `.csv`.
    Csv,
    /// Apache Parquet, `.parquet`.
    Parquet,
}

impl TableFormat {
    /// The format that a file name asks for.
    ///
    /// # Errors
    /// If the extension is neither `.csv` nor `.parquet`.
    pub fn of(path: &Path) -> Result<TableFormat> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("csv") => Ok(TableFormat::Csv),
            Some("parquet") => Ok(TableFormat::Parquet),
            _ => Err(Error::content(path, "the name of a table must end in .csv or .parquet")),
        }
    }
}

/// Reads all numeric columns of a CSV or Parquet file.
///
/// # Errors
/// If the extension is neither `.csv` nor `.parquet`, or as [`crate::csv::read`] and [`crate::parquet::read`].
pub fn read_table(path: impl AsRef<Path>) -> Result<Table> {
    let path = path.as_ref();
    match TableFormat::of(path)? {
        TableFormat::Csv => crate::csv::read(path, None),
        TableFormat::Parquet => crate::parquet::read(path, None),
    }
}

/// Reads the named columns of a CSV or Parquet file, in the order asked for; others are passed over.
///
/// # Errors
/// As [`read_table`]; also if a column is missing, with the nearest name.
pub fn read_columns(path: impl AsRef<Path>, names: &[&str]) -> Result<Table> {
    let path = path.as_ref();
    match TableFormat::of(path)? {
        TableFormat::Csv => crate::csv::read(path, Some(names)),
        TableFormat::Parquet => crate::parquet::read(path, Some(names)),
    }
}

/// Writes a CSV or Parquet file beside and renames it. Equal tables give equal bytes.
///
/// # Errors
/// If the extension is neither `.csv` nor `.parquet`, or the file cannot be written.
pub fn write_table(path: impl AsRef<Path>, table: &Table) -> Result<()> {
    let path = path.as_ref();
    match TableFormat::of(path)? {
        TableFormat::Csv => crate::csv::write(path, table),
        TableFormat::Parquet => crate::parquet::write(path, table),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_chooses_the_format() {
        assert_eq!(TableFormat::of(Path::new("x/Y.CSV")).unwrap(), TableFormat::Csv);
        assert_eq!(TableFormat::of(Path::new("y.parquet")).unwrap(), TableFormat::Parquet);
        let error = TableFormat::of(Path::new("y.xlsx")).unwrap_err().to_string();
        assert_eq!(error, "y.xlsx: the name of a table must end in .csv or .parquet");
    }
}
