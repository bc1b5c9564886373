//! Tables with columns of numbers and columns of words, written as CSV or Parquet: the summary of a study, for instance.
//!
//! A number that is not known is an empty cell in CSV and NaN in Parquet; words in CSV are quoted where they need it (RFC 4180). Units
//! are metadata of a Parquet file, as of all tables; CSV does not have them. Equal tables give equal bytes.

use std::io::Write;
use std::path::Path;

use granum_core::quantity::format_number;

use super::parquet;
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum MixedValues {
    /// Numbers; NaN where there is none.
    Numbers(Vec<f64>),
    /// Words; empty where there is none.
    Words(Vec<String>),
}

/// A named column of numbers or of words.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedColumn {
    /// Its name.
    pub name: String,
    /// SI unit of numbers; empty for pure numbers and words.
    pub unit: String,
    /// One value per row.
    pub values: MixedValues,
}

impl MixedColumn {
    /// A column of numbers.
    pub fn numbers(name: impl Into<String>, unit: impl Into<String>, values: Vec<f64>) -> MixedColumn {
        MixedColumn { name: name.into(), unit: unit.into(), values: MixedValues::Numbers(values) }
    }

    /// A column of words.
    pub fn words(name: impl Into<String>, values: Vec<String>) -> MixedColumn {
        MixedColumn { name: name.into(), unit: String::new(), values: MixedValues::Words(values) }
    }

    /// The numbers of a column of numbers.
    pub fn as_numbers(&self) -> Option<&[f64]> {
        match &self.values {
            MixedValues::Numbers(values) => Some(values),
            MixedValues::Words(_) => None,
        }
    }

    /// Number of its rows.
    pub fn rows(&self) -> usize {
        match &self.values {
            MixedValues::Numbers(values) => values.len(),
            MixedValues::Words(values) => values.len(),
        }
    }

    /// The value of a row as text in full precision; empty where there is none.
    pub fn text(&self, row: usize) -> String {
        match &self.values {
            MixedValues::Numbers(values) => values
                .get(row)
                .filter(|value| !value.is_nan())
                .map_or_else(String::new, |value| format_number(*value)),
            MixedValues::Words(values) => values.get(row).cloned().unwrap_or_default(),
        }
    }
}

/// Columns of equal length.
///
/// ```
/// use granum_io::formats::mixed::{MixedColumn, MixedTable};
///
/// let mut table = MixedTable::default();
/// table.push(MixedColumn::words("name", vec!["a".into(), "b".into()]));
/// table.push(MixedColumn::numbers("void_ratio", "", vec![0.65, f64::NAN]));
/// assert_eq!(table.csv(), "name,void_ratio\na,0.65\nb,\n");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MixedTable {
    columns: Vec<MixedColumn>,
}

impl MixedTable {
    /// Adds a column at the right.
    pub fn push(&mut self, column: MixedColumn) {
        self.columns.push(column);
    }

    /// The columns in their order.
    pub fn columns(&self) -> &[MixedColumn] {
        &self.columns
    }

    /// Number of rows, that of the longest column.
    pub fn rows(&self) -> usize {
        self.columns.iter().map(MixedColumn::rows).max().unwrap_or(0)
    }

    /// The table as CSV.
    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| format!("{}\n", cells.join(","));
        let mut text = line(self.columns.iter().map(|column| quoted(&column.name)).collect());
        for row in 0..self.rows() {
            text.push_str(&line(self.columns.iter().map(|column| quoted(&column.text(row))).collect()));
        }
        text
    }

    /// Writes the table as CSV or Parquet, by the extension of the file, under a temporary name that is then changed.
    ///
    /// # Errors
    /// If the extension is another, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("csv") => write_atomically(path, |file| file.write_all(self.csv().as_bytes())),
            Some("parquet") => parquet::write_mixed(path, self),
            _ => {
                let message = "the format follows from the extension of the name: .csv or .parquet";
                Err(Error::content(path, message))
            }
        }
    }
}

/// A cell of CSV.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.starts_with('#') {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> MixedTable {
        let mut table = MixedTable::default();
        table.push(MixedColumn::words("name", vec!["a,b".into(), "say \"x\"\nhere".into()]));
        table.push(MixedColumn::numbers("stress", "Pa", vec![5e4, f64::NAN]));
        table
    }

    #[test]
    fn words_are_quoted_where_they_need_it() {
        assert_eq!(table().csv(), "name,stress\n\"a,b\",50000\n\"say \"\"x\"\"\nhere\",\n");
    }

    #[test]
    fn numbers_come_back_from_parquet_and_words_beside_them_do_no_harm() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("t.parquet");
        table().write(&path).unwrap();
        let read = crate::read_table(&path).unwrap();
        let column = &read.columns()[0];
        assert_eq!((column.name.as_str(), column.unit.as_str(), column.values[0]), ("stress", "Pa", 5e4));
        assert!(column.values[1].is_nan() && read.columns().len() == 1);
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.windows(3).any(|part| part == b"a,b"), "the words are in the file");
        let error = table().write(&base.path().join("t.xls")).unwrap_err().to_string();
        assert!(error.contains(".csv or .parquet"), "{error}");
    }
}
