//! Tables of numbers by column, the common shape of every series, data set and snapshot.

use std::path::Path;

use crate::error::{Error, Result, nearest};

/// What the numbers of a column are: how Parquet stores them. In memory all are doubles, in CSV text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColumnKind {
    /// Real numbers (`DOUBLE`).
    #[default]
    Real,
    /// Whole numbers of at most 2^53 (`INT64`).
    Integer,
    /// Truth values, 0 or 1 (`BOOLEAN`).
    Boolean,
}

/// A named column of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Name, unique in its table.
    pub name: String,
    /// SI unit, e.g. "Pa"; empty for a pure number or where the file does not tell (CSV).
    pub unit: String,
    /// One value a row.
    pub values: Vec<f64>,
    /// What the values are.
    pub kind: ColumnKind,
}

impl Column {
    /// A column of real numbers from its parts.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, values: Vec<f64>) -> Self {
        Column { name: name.into(), unit: unit.into(), values, kind: ColumnKind::Real }
    }

    /// The same column of another kind. A value that is not of that kind (a fraction, NaN) is an error when the column is
    /// written to Parquet.
    pub fn of_kind(self, kind: ColumnKind) -> Self {
        Column { kind, ..self }
    }
}

/// Columns of equal length with different names.
///
/// ```
/// use granum_io::{Column, Table};
/// let table = Table::new(vec![
///     Column::new("strain", "", vec![0.0, 0.1]),
///     Column::new("mean_stress", "Pa", vec![2e4, 2.01e4]),
/// ]).unwrap();
/// assert_eq!(table.column("mean_stress").unwrap(), [2e4, 2.01e4]);
/// let error = table.column("mean_stres").unwrap_err();
/// assert_eq!(error.to_string(), "there is no column mean_stres; did you mean mean_stress?");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    columns: Vec<Column>,
}

impl Table {
    /// A table from columns.
    ///
    /// # Errors
    /// [`Error::Table`] if two columns have one name, a name is empty, or their lengths differ.
    pub fn new(columns: Vec<Column>) -> Result<Table> {
        let mut names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        names.sort_unstable();
        if names.contains(&"") {
            return Err(Error::Table("a column has no name".into()));
        }
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::Table(format!("two columns have the name {}", pair[0])));
        }
        let rows = columns.first().map_or(0, |column| column.values.len());
        if let Some(odd) = columns.iter().find(|column| column.values.len() != rows) {
            let (name, length) = (&odd.name, odd.values.len());
            let first = &columns[0].name;
            return Err(Error::Table(format!("column {name} has {length} rows, but {first} has {rows}")));
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

    /// The names in their order.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// True if there is a column of that name.
    pub fn has(&self, name: &str) -> bool {
        self.names().any(|known| known == name)
    }

    /// The values of a column.
    ///
    /// # Errors
    /// [`Error::Table`] that suggests the nearest name.
    pub fn column(&self, name: &str) -> Result<&[f64]> {
        match self.columns.iter().find(|column| column.name == name) {
            Some(column) => Ok(&column.values),
            None => Err(Error::Table(format!("there is no column {name}; {}", suggest(name, self.names())))),
        }
    }

    /// The values of several columns, in the order asked for.
    ///
    /// # Errors
    /// As [`Table::column`].
    pub fn select<const N: usize>(&self, names: [&str; N]) -> Result<[&[f64]; N]> {
        let mut found = [&[] as &[f64]; N];
        for (slot, name) in found.iter_mut().zip(names) {
            *slot = self.column(name)?;
        }
        Ok(found)
    }

    /// Adds a column, or replaces the one of the same name.
    ///
    /// # Errors
    /// [`Error::Table`] if its length is not that of the table.
    pub fn set(&mut self, column: Column) -> Result<()> {
        let others = self.columns.iter().filter(|known| known.name != column.name);
        if let Some(other) = others.clone().next()
            && other.values.len() != column.values.len()
        {
            return Err(Error::Table(format!(
                "column {} has {} rows, but {} has {}",
                column.name,
                column.values.len(),
                other.name,
                other.values.len()
            )));
        }
        match self.columns.iter_mut().find(|known| known.name == column.name) {
            Some(known) => *known = column,
            None => self.columns.push(column),
        }
        Ok(())
    }
}

/// "did you mean x?" or the list of what is there.
pub(crate) fn suggest<'a>(name: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(name, names.clone()) {
        Some(near) => format!("did you mean {near}?"),
        None => {
            let all: Vec<&str> = names.take(40).collect();
            if all.is_empty() { "there are none".into() } else { format!("there are: {}", all.join(", ")) }
        }
    }
}

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
    fn select_keeps_the_order_asked_for() {
        let table =
            Table::new(vec![Column::new("a", "", vec![1.0]), Column::new("b", "", vec![2.0])]).unwrap();
        let [b, a] = table.select(["b", "a"]).unwrap();
        assert_eq!((a, b), (&[1.0][..], &[2.0][..]));
        let error = table.column("zeta").unwrap_err().to_string();
        assert_eq!(error, "there is no column zeta; there are: a, b");
    }

    #[test]
    fn the_extension_chooses_the_format() {
        assert_eq!(TableFormat::of(Path::new("x/Y.CSV")).unwrap(), TableFormat::Csv);
        assert_eq!(TableFormat::of(Path::new("y.parquet")).unwrap(), TableFormat::Parquet);
        let error = TableFormat::of(Path::new("y.xlsx")).unwrap_err().to_string();
        assert_eq!(error, "y.xlsx: the name of a table must end in .csv or .parquet");
    }
}
