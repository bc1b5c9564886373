//! Columns of numbers by name, in SI units, whatever unit the header gives them.

use std::collections::HashSet;
use std::path::Path;

use granum_core::quantity::{Dimension, parse_quantity};
use granum_core::{Column, Table};

use super::{Sheet, Sought, split};
use crate::error::Result;

/// Reads columns of numbers in SI units: those of `names`, and of `optional` the ones that are there. A column whose header has a unit is
/// converted; `dimension` says what units it can have.
///
/// # Errors
/// If the file cannot be read; with line and column for what is wrong in it; for a missing column.
pub fn read_inputs(
    path: &Path,
    names: &[&str],
    optional: &[&str],
    dimension: &dyn Fn(&str) -> Dimension,
) -> Result<Table> {
    let wanted: HashSet<&str> = names.iter().chain(optional).copied().collect();
    let is_name = |cell: &str| wanted.contains(cell) || wanted.contains(split(cell).0);
    let sheet = Sheet::open(path, &Sought { is_name: &is_name, count: wanted.len(), may_have_units: true })?;
    let mut columns = Vec::new();
    for name in names {
        let at = place(&sheet, name)?;
        columns.push((*name, at.map_or_else(|| sheet.position(name), Ok)?));
    }
    for name in optional {
        columns.extend(place(&sheet, name)?.map(|at| (*name, at)));
    }
    let factors =
        columns.iter().map(|(name, at)| factor(&sheet, name, *at, dimension)).collect::<Result<Vec<_>>>()?;
    let mut values = vec![Vec::new(); columns.len()];
    let mut rows = sheet.rows(&columns.iter().map(|(_, at)| *at).collect::<Vec<_>>())?;
    while rows.advance()? {
        for (((name, at), factor), values) in columns.iter().zip(&factors).zip(&mut values) {
            let value = rows.number(*at, name)?;
            values.push(factor.map_or(value, |factor| value * factor));
        }
    }
    let columns =
        columns.iter().zip(values).map(|((name, _), values)| Column::new(*name, "", values)).collect();
    Ok(Table::new(columns)?)
}

/// The column of a name, which stands alone or with a unit.
fn place(sheet: &Sheet, name: &str) -> Result<Option<usize>> {
    let header = sheet.header();
    let exact = header.iter().position(|cell| cell == name);
    let mut with_unit = header.iter().enumerate().filter(|(_, cell)| split(cell).0 == name).map(|(at, _)| at);
    let first = exact.or_else(|| with_unit.next());
    if let Some(second) = with_unit.find(|at| Some(*at) != first) {
        let message = format!("two columns are {name}");
        return Err(sheet.header_error(second, message).into());
    }
    Ok(first)
}

/// What the numbers of a column are multiplied by, if it has a unit.
fn factor(
    sheet: &Sheet,
    name: &str,
    at: usize,
    dimension: &dyn Fn(&str) -> Dimension,
) -> Result<Option<f64>> {
    // A name that is known as it stands has no unit in it.
    let unit = match sheet.header()[at] == name {
        true => sheet.source.units.get(at).map_or("", String::as_str),
        false => sheet.name_and_unit(at)?.1,
    };
    if unit.is_empty() {
        return Ok(None);
    }
    let factor = parse_quantity(&format!("1 {unit}"), dimension(name));
    factor
        .map(Some)
        .map_err(|why| sheet.header_error(at, format!("the unit of {name}: 1 {unit} {why}")).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Table> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        std::fs::write(&path, text).unwrap();
        let dimension = |name: &str| if name == "stress" { Dimension::STRESS } else { Dimension::NUMBER };
        read_inputs(&path, &["stress", "strain"], &["run"], &dimension)
    }

    #[test]
    fn columns_are_converted_where_they_have_units() {
        for text in [
            "\"strain\",\"stress\"\n\"0.05\",\"50000\"\n",
            "strain;stress\n0,05;50000\n",
            "strain (%);other;stress [kPa]\n5;x;50\n",
            "strain;stress\n%;kPa\n5;50\n",
        ] {
            let table = read(text).unwrap();
            assert_eq!(table.names().collect::<Vec<_>>(), ["stress", "strain"]);
            assert_eq!(
                (table.column("stress").unwrap(), table.column("strain").unwrap()),
                (&[50e3][..], &[0.05][..]),
                "{text}"
            );
        }
        assert_eq!(read("run,strain,stress\n2,0,1\n").unwrap().column("run").unwrap(), [2.0]);
        for (text, part) in [
            ("strain,stress (kg)\n0,1\n", "rows.csv:1:8: the unit of stress: 1 kg is a mass"),
            ("strain,stress,stress (kPa)\n0,1,2\n", "rows.csv:1:15: two columns are stress"),
            ("strain,strss\n0,1\n", "there is no column stress; did you mean strss?"),
            (
                "strain,stress\n0,1 kPa\n",
                "rows.csv:2:3: stress = \"1 kPa\" is not a number: the unit belongs into the header",
            ),
        ] {
            let said = read(text).unwrap_err().to_string();
            assert!(said.contains(part), "{text}: {said}");
        }
    }

    /// Columns that are passed over cost no more than their reading.
    #[test]
    fn many_columns_that_are_not_needed_are_no_burden() {
        let many = 60_000;
        let names: String = (0..many).map(|k| format!(",c{k}")).collect();
        let text = format!("strain,stress{names}\n0,1{}\n", ",1".repeat(many));
        let start = std::time::Instant::now();
        assert_eq!(read(&text).unwrap().rows(), 1);
        assert!(start.elapsed().as_secs_f64() < 10.0, "{:?}", start.elapsed());
    }
}
