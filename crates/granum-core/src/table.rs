//! Tables by column, of numbers and of words: the common form of all time series, data sets, snapshots and tables of runs.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::names::suggestion;
use crate::quantity::format_number;

/// Errors of a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A column has no name.
    #[error("a column has no name")]
    NoName,
    /// Two columns have the same name.
    #[error("two columns have the name {0}")]
    SameName(String),
    /// Columns have different lengths.
    #[error("column {name} has {rows} rows, but {other} has {other_rows}")]
    Lengths {
        /// The column.
        name: String,
        /// Its number of rows.
        rows: usize,
        /// Another column.
        other: String,
        /// Its number of rows.
        other_rows: usize,
    },
    /// A column is missing.
    #[error("there is no column {name}; {suggestion}")]
    Missing {
        /// Name of the column.
        name: String,
        /// The nearest name, or all existing names.
        suggestion: String,
    },
    /// A column of words was requested as numbers.
    #[error("column {0} holds words, not numbers")]
    Words(String),
}

type Result<T> = std::result::Result<T, TableError>;

/// The kind of the values of a column, which decides how Parquet stores them. In memory all are doubles, in CSV text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColumnKind {
    /// Real numbers (`DOUBLE`).
    #[default]
    Real,
    /// Whole numbers of at most 2^53 (`INT64`).
    Integer,
    /// Truth values, 0 or 1 (`BOOLEAN`).
    Boolean,
    /// Words, such as the names of laws (UTF-8 text): a value is the number of a word in [`Column::words`], from 0.
    Word,
}

/// A named column of numbers or of words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Name, unique in its table.
    pub name: String,
    /// SI unit, e.g. "Pa"; empty for a pure number or where the file does not contain it (CSV).
    pub unit: String,
    /// One value per row.
    pub values: Vec<f64>,
    /// The kind of the values.
    pub kind: ColumnKind,
    /// The words of a column of words, each once; empty for numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
}

impl Column {
    /// A column of real numbers from its parts.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, values: Vec<f64>) -> Self {
        Column { name: name.into(), unit: unit.into(), values, kind: ColumnKind::Real, words: Vec::new() }
    }

    /// A column of words, with one text for each row; an empty text stands for none.
    ///
    /// ```
    /// use granum_core::Column;
    ///
    /// let law = Column::of_words("contact.normal", ["hertz", "jkr", "hertz"]);
    /// assert_eq!((law.values.as_slice(), law.words.len()), (&[0.0, 1.0, 0.0][..], 2));
    /// assert_eq!(law.word(2), Some("hertz"));
    /// ```
    pub fn of_words<T: Into<String>>(name: impl Into<String>, texts: impl IntoIterator<Item = T>) -> Self {
        let mut numbers: BTreeMap<String, usize> = BTreeMap::new();
        let mut words = Vec::new();
        let number = |text: T| {
            let text = text.into();
            if let Some(number) = numbers.get(&text) {
                return *number as f64;
            }
            words.push(text.clone());
            numbers.insert(text, words.len() - 1);
            (words.len() - 1) as f64
        };
        let values = texts.into_iter().map(number).collect();
        Column { words, kind: ColumnKind::Word, ..Column::new(name, "", values) }
    }

    /// The same column without a row.
    fn without_values(&self) -> Column {
        let Column { name, unit, kind, words, .. } = self;
        Column {
            name: name.clone(),
            unit: unit.clone(),
            values: Vec::new(),
            kind: *kind,
            words: words.clone(),
        }
    }

    /// True if it holds words.
    pub fn has_words(&self) -> bool {
        self.kind == ColumnKind::Word
    }

    /// The numbers; `None` for a column of words.
    pub fn numbers(&self) -> Option<&[f64]> {
        (!self.has_words()).then_some(self.values.as_slice())
    }

    /// The word of a row; `None` for a column of numbers or a row that does not exist.
    pub fn word(&self, row: usize) -> Option<&str> {
        let number = self.values.get(row).filter(|_| self.has_words())?;
        self.words.get(*number as usize).map(String::as_str)
    }

    /// The value of a row as text in full precision; empty for NaN and where there is none.
    pub fn text(&self, row: usize) -> String {
        match (self.word(row), self.values.get(row)) {
            (Some(word), _) => word.to_string(),
            (None, Some(value)) if !self.has_words() && !value.is_nan() => format_number(*value),
            _ => String::new(),
        }
    }

    /// The same column with another kind. A value that does not fit the kind (a fraction, NaN) is an error when the column
    /// is written to Parquet.
    pub fn of_kind(self, kind: ColumnKind) -> Self {
        Column { kind, ..self }
    }
}

/// Columns of equal length with distinct names.
///
/// ```
/// use granum_core::{Column, Table};
/// let table = Table::new(vec![
///     Column::new("strain", "", vec![0.0, 0.1]),
///     Column::new("mean_stress", "Pa", vec![2e4, 2.01e4]),
/// ]).unwrap();
/// assert_eq!(table.column("mean_stress").unwrap(), [2e4, 2.01e4]);
/// let error = table.column("mean_stres").unwrap_err();
/// assert_eq!(error.to_string(), "there is no column mean_stres; did you mean mean_stress?");
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    columns: Vec<Column>,
}

impl Table {
    /// A table from columns.
    ///
    /// # Errors
    /// [`TableError`] if two columns have the same name, a name is empty, or their lengths differ.
    pub fn new(columns: Vec<Column>) -> Result<Table> {
        let mut names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        names.sort_unstable();
        if names.contains(&"") {
            return Err(TableError::NoName);
        }
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(TableError::SameName(pair[0].to_string()));
        }
        let rows = columns.first().map_or(0, |column| column.values.len());
        if let Some(odd) = columns.iter().find(|column| column.values.len() != rows) {
            return Err(lengths(odd, &columns[0]));
        }
        Ok(Table { columns })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The columns in their order.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The columns in their order, taken out of the table.
    pub fn into_columns(self) -> Vec<Column> {
        self.columns
    }

    /// The names in their order.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// True if there is a column with the given name.
    pub fn has(&self, name: &str) -> bool {
        self.names().any(|known| known == name)
    }

    /// The values of a column.
    ///
    /// # Errors
    /// [`TableError`] that suggests the nearest name, or if the column holds words.
    pub fn column(&self, name: &str) -> Result<&[f64]> {
        match self.get(name).map(|column| column.numbers()) {
            Some(numbers) => numbers.ok_or_else(|| TableError::Words(name.to_string())),
            None => {
                let suggestion = suggestion(name, self.names());
                Err(TableError::Missing { name: name.to_string(), suggestion })
            }
        }
    }

    /// The values of a column, if there is one of numbers with the given name.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.get(name).and_then(Column::numbers)
    }

    /// The column of the given name, of numbers or of words, if there is one.
    pub fn get(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// True if a column holds words.
    pub fn has_words(&self) -> bool {
        self.columns.iter().any(Column::has_words)
    }

    /// The columns for which `keep` is true.
    pub fn columns_where(&self, keep: impl Fn(&Column) -> bool) -> Table {
        Table { columns: self.columns.iter().filter(|column| keep(column)).cloned().collect() }
    }

    /// The rows of the given numbers, in their order; a number beyond the last row is omitted.
    pub fn rows_at(&self, rows: &[usize]) -> Table {
        let chosen = |column: &Column| Column {
            values: rows.iter().filter_map(|row| column.values.get(*row).copied()).collect(),
            ..column.without_values()
        };
        Table { columns: self.columns.iter().map(chosen).collect() }
    }

    /// The values of several columns, in the requested order.
    ///
    /// # Errors
    /// As for [`Table::column`].
    pub fn select<const N: usize>(&self, names: [&str; N]) -> Result<[&[f64]; N]> {
        let mut found = [&[] as &[f64]; N];
        for (slot, name) in found.iter_mut().zip(names) {
            *slot = self.column(name)?;
        }
        Ok(found)
    }

    /// Removes and returns the column of a given name, if there is one.
    pub fn remove(&mut self, name: &str) -> Option<Column> {
        let at = self.columns.iter().position(|column| column.name == name)?;
        Some(self.columns.remove(at))
    }

    /// Adds a column, or replaces the one of the same name.
    ///
    /// # Errors
    /// [`TableError`] if its length differs from that of the table.
    pub fn set(&mut self, column: Column) -> Result<()> {
        let others = self.columns.iter().filter(|known| known.name != column.name);
        if let Some(other) = others.clone().next()
            && other.values.len() != column.values.len()
        {
            return Err(lengths(&column, other));
        }
        match self.columns.iter_mut().find(|known| known.name == column.name) {
            Some(known) => *known = column,
            None => self.columns.push(column),
        }
        Ok(())
    }
}

fn lengths(odd: &Column, other: &Column) -> TableError {
    TableError::Lengths {
        name: odd.name.clone(),
        rows: odd.values.len(),
        other: other.name.clone(),
        other_rows: other.values.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_must_fit_together() {
        let column = |name: &str, rows: usize| Column::new(name, "", vec![0.0; rows]);
        let message = |columns| Table::new(columns).unwrap_err().to_string();
        assert_eq!(message(vec![column("a", 2), column("b", 3)]), "column b has 3 rows, but a has 2");
        assert_eq!(message(vec![column("a", 2), column("a", 2)]), "two columns have the name a");
        assert_eq!(message(vec![column("", 2)]), "a column has no name");
        let mut table = Table::new(vec![column("a", 2)]).unwrap();
        assert!(table.set(column("b", 3)).is_err());
        table.set(column("a", 3)).unwrap();
        table.set(column("b", 3)).unwrap();
        assert_eq!((table.rows(), table.names().collect::<Vec<_>>()), (3, vec!["a", "b"]));
    }

    #[test]
    fn words_are_no_numbers() {
        let law = Column::of_words("law", ["hertz", "", "jkr", "hertz"]);
        let table = Table::new(vec![law, Column::new("x", "m", vec![1.0, f64::NAN, 0.5, 2.0])]).unwrap();
        assert_eq!(table.column("law").unwrap_err().to_string(), "column law holds words, not numbers");
        assert_eq!((table.values("law"), table.has("law"), table.has_words()), (None, true, true));
        let texts = |row| table.columns().iter().map(|column| column.text(row)).collect::<Vec<_>>();
        assert_eq!([texts(0), texts(1), texts(4)], [["hertz", "1"], ["", ""], ["", ""]]);
        let some = table.rows_at(&[3, 2, 9]);
        assert_eq!((some.rows(), some.get("law").unwrap().word(1)), (2, Some("jkr")));
        assert_eq!(table.columns_where(|column| column.unit == "m").names().collect::<Vec<_>>(), ["x"]);
    }

    #[test]
    fn select_keeps_the_order_asked_for() {
        let table =
            Table::new(vec![Column::new("a", "", vec![1.0]), Column::new("b", "", vec![2.0])]).unwrap();
        let [b, a] = table.select(["b", "a"]).unwrap();
        assert_eq!((a, b), (&[1.0][..], &[2.0][..]));
        let error = table.column("zeta").unwrap_err().to_string();
        assert_eq!(error, "there is no column zeta; there are: a, b");
    }
}
