//! The cells of a table as text, for readers that know only afterwards what they are: the rows of a design.

use std::path::Path;

use super::{Sheet, Sought, split};
use crate::error::Result;

/// A row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct CellRow {
    /// The line in which it begins, from 1.
    pub line: usize,
    /// The text of that line.
    pub text: String,
    /// The cells in the order of the columns. Numbers have a decimal point, and the unit of their column if the header or the row below it
    /// has one.
    pub cells: Vec<String>,
}

/// Reads a table of cells that may be numbers, quantities or words: the names of its columns and its rows. These names tell the header from
/// lines before it; a column may have another name.
///
/// # Errors
/// If the file cannot be read or is no table: with line and column.
pub fn read_cells(path: &Path, names: &[&str]) -> Result<(Vec<String>, Vec<CellRow>)> {
    let is_name = |cell: &str| names.contains(&cell) || names.contains(&split(cell).0);
    let sheet = Sheet::open(path, &Sought { is_name: &is_name, count: names.len(), may_have_units: true })?;
    let columns = (0..sheet.header().len())
        .map(|at| match names.contains(&sheet.header()[at].as_str()) {
            true => Ok((sheet.header()[at].as_str(), sheet.source.units.get(at).map_or("", String::as_str))),
            false => sheet.name_and_unit(at),
        })
        .collect::<Result<Vec<_>>>()?;
    if let Some(unnamed) = columns.iter().position(|(name, _)| name.is_empty()) {
        return Err(sheet.header_error(unnamed, "a column has no name".into()).into());
    }
    let all: Vec<usize> = (0..columns.len()).collect();
    let mut rows = sheet.rows(&all)?;
    let mut cell_rows = Vec::new();
    while rows.advance()? {
        let cell = |at: usize| {
            let cell = rows.quantity(at);
            let unit = columns[at].1;
            // The unit of a pure number says nothing.
            match !["", "1"].contains(&unit) && cell.parse::<f64>().is_ok() {
                true => format!("{cell} {unit}"),
                false => cell,
            }
        };
        let cells = all.iter().map(|at| cell(*at)).collect();
        cell_rows.push(CellRow { line: rows.line(), text: rows.text().to_string(), cells });
    }
    Ok((columns.into_iter().map(|(name, _)| name.to_string()).collect(), cell_rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_points_and_the_units_of_their_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let text = "Plan;12\nfriction;pressure (kPa);law;modulus\n;;;GPa\n0,2;50,5;hertz, dense;3\n\n0,4;100 MPa;;2,5\n";
        std::fs::write(&path, text).unwrap();
        let (names, rows) = read_cells(&path, &["friction", "pressure", "law", "modulus"]).unwrap();
        assert_eq!(names, ["friction", "pressure", "law", "modulus"]);
        assert_eq!(rows[0].cells, ["0.2", "50.5 kPa", "hertz, dense", "3 GPa"]);
        assert_eq!(rows[1].cells, ["0.4", "100 MPa", "", "2.5 GPa"]);
        assert_eq!((rows[1].line, rows[1].text.as_str()), (6, "0,4;100 MPa;;2,5"));
    }
}
