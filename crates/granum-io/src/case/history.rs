//! Histories of strains and stresses for the path `history`: from a CSV file, or as columns and rows of the case itself.
//!
//! The case of a run contains the rows, so that the run no longer needs the file.

use std::io::BufRead;
use std::path::Path;

use granum_dem::loading::{History, HistoryQuantity, MOST_ROWS};
use toml::de::DeValue;

use super::doubt::Doubt;
use super::stage_values::{Mistake, Node, Parsed, number, text};
use super::suggestion::meant;
use super::unit::dimension;
use crate::error::{Error, Result};
use crate::formats::lines::{self, Lines};
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// Keys of a stage that give a history.
pub(super) const HISTORY_KEYS: [&str; 3] = ["file", "columns", "rows"];

/// The quantity to which a column of a file belongs.
struct SourceColumn {
    /// None for the time.
    quantity: Option<HistoryQuantity>,
    /// The factor by which a value is multiplied.
    factor: f64,
    /// True if the header names no unit.
    is_bare: bool,
}

/// The dimension of a column.
pub(super) fn dimension_of(quantity: HistoryQuantity) -> Dimension {
    dimension(if matches!(quantity, HistoryQuantity::Stress(_)) { "Pa" } else { "1" })
}

/// Reads a file.
///
/// # Errors
/// If it cannot be read; [`Error::Input`] with line and column for what is wrong in it.
pub(super) fn read(path: &Path) -> Result<History> {
    read_lines(&mut Lines::open(path)?)
}

/// Refuses a file if the largest value of a column whose name has no unit is in doubt.
///
/// # Errors
/// As for [`read`]; [`Error::Input`] at the name of the column.
pub(super) fn check_bare(
    path: &Path,
    mut doubt: impl FnMut(HistoryQuantity, f64) -> Option<Doubt>,
) -> Result<()> {
    let history = read(path)?;
    let lines = &mut Lines::open(path)?;
    let columns = header(lines)?;
    let names: Vec<(usize, String)> = lines.cells().map(|(start, cell)| (start, cell.to_string())).collect();
    let quantities =
        columns.iter().zip(names).filter_map(|(column, name)| Some((column, column.quantity?, name)));
    for (k, (column, quantity, (start, cell))) in quantities.enumerate() {
        let larger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let largest = history.rows.iter().filter_map(|row| row.get(k).copied()).fold(0.0, larger);
        if let Some(doubt) = doubt(quantity, largest).filter(|_| column.is_bare) {
            let name = quantity.name();
            let message = format!("{name} goes to {} and {}", format_number(largest), doubt.message());
            let error = lines.cell_error(start, &cell, message).with_help(doubt.header_help(&name));
            return Err(error.into());
        }
    }
    Ok(())
}

fn read_lines<R: BufRead>(lines: &mut Lines<R>) -> Result<History> {
    let places = header(lines)?;
    let columns = places.iter().filter_map(|place| place.quantity).collect();
    let mut history = History { columns, rows: Vec::new() };
    let mut time = f64::NEG_INFINITY;
    while lines.advance()? {
        if lines.is_empty() {
            continue;
        }
        let mut row = Vec::with_capacity(places.len());
        let mut count = 0;
        for (start, cell) in lines.cells() {
            if let Some(place) = places.get(count) {
                let value = value(lines, place, start, cell)?;
                match place.quantity {
                    Some(_) => row.push(value),
                    None if value <= time => {
                        let message = format!("time = {cell} does not increase from row to row");
                        return Err(lines.cell_error(start, cell, message).into());
                    }
                    None => time = value,
                }
            }
            count += 1;
        }
        if count != places.len() {
            let message = format!("the row has {count} cells, but the header names {} columns", places.len());
            return Err(lines.error(0..lines.line().len(), message).into());
        }
        history.rows.push(row);
        if history.rows.len() > MOST_ROWS {
            let message = format!("the history has more than {MOST_ROWS} rows");
            return Err(lines.error(0..lines.line().len(), message).into());
        }
    }
    match history.fault() {
        None => Ok(history),
        Some(fault) => Err(Error::content(Path::new(lines.file()), fault)),
    }
}

/// The columns that the first line names.
fn header<R: BufRead>(lines: &mut Lines<R>) -> Result<Vec<SourceColumn>> {
    while lines.advance()? {
        if lines.is_empty() {
            continue;
        }
        // What every table refuses: empty names, two alike, other separators.
        lines::names(lines)?;
        let place = |(start, cell): (usize, &str)| {
            place(cell.trim_matches('"')).map_err(|(message, help)| {
                Error::from(lines.cell_error(start, cell, message).with_help(help))
            })
        };
        return lines.cells().map(place).collect();
    }
    Err(Error::content(Path::new(lines.file()), "is empty; the first line must name the columns"))
}

/// What the name of a column says, e.g. `xx_stress (kPa)`; what is wrong with it and what would be right.
fn place(cell: &str) -> std::result::Result<SourceColumn, (String, String)> {
    let (name, unit) = match cell.split_once(['(', '[']) {
        Some((name, unit)) => (name.trim(), unit.trim_end_matches([')', ']']).trim()),
        None => (cell, ""),
    };
    if name == "time" {
        return Ok(SourceColumn { quantity: None, factor: 1.0, is_bare: false });
    }
    let Some(quantity) = HistoryQuantity::named(name) else {
        let names: Vec<String> = HistoryQuantity::all().map(HistoryQuantity::name).collect();
        let help = meant(name, names.iter().map(String::as_str).chain(["time"]));
        return Err((format!("{name} is not a column of a history"), help));
    };
    let factor = match unit {
        "" => Ok(1.0),
        unit => parse_quantity(&format!("1 {unit}"), dimension_of(quantity)),
    };
    let wrong = |why| {
        (format!("the unit of {name}: 1 {unit} {why}"), format!("e.g. {name} (kPa), or no unit for SI"))
    };
    Ok(SourceColumn { quantity: Some(quantity), factor: factor.map_err(wrong)?, is_bare: unit.is_empty() })
}

fn value<R: BufRead>(lines: &Lines<R>, place: &SourceColumn, start: usize, cell: &str) -> Result<f64> {
    let name = place.quantity.map_or_else(|| "time".to_string(), HistoryQuantity::name);
    let value = lines::number(lines, &name, start, cell)? * place.factor + 0.0;
    if value.is_finite() {
        return Ok(value);
    }
    Err(lines.cell_error(start, cell, format!("{name} = {cell} is not finite")).into())
}

/// The key `columns` of a stage.
pub(super) fn columns(value: &Node<'_>) -> Parsed<Vec<HistoryQuantity>> {
    let DeValue::Array(items) = value.get_ref() else {
        let help = "e.g. columns = [\"xx_strain\", \"yy_stress\"]".to_string();
        return Err(Mistake(value.span(), "is not a list of columns".into(), Some(help)));
    };
    let column = |item: &Node<'_>| {
        let name = text(item)?;
        HistoryQuantity::named(&name).ok_or_else(|| {
            let names: Vec<String> = HistoryQuantity::all().map(HistoryQuantity::name).collect();
            let help = meant(&name, names.iter().map(String::as_str));
            Mistake(item.span(), "is not a column of a history".into(), Some(help))
        })
    };
    items.iter().map(column).collect()
}

/// The key `rows` of a stage with these columns.
pub(super) fn rows(value: &Node<'_>, columns: Vec<HistoryQuantity>) -> Parsed<History> {
    let wrong =
        |why: String| Mistake(value.span(), why, Some("e.g. rows = [[0.0, 1e5], [0.01, 1e5]]".into()));
    let DeValue::Array(items) = value.get_ref() else { return Err(wrong("is not a list of rows".into())) };
    let row = |item: &Node<'_>| {
        let DeValue::Array(cells) = item.get_ref() else {
            return Err(Mistake(item.span(), "is not a row of numbers".into(), None));
        };
        let quantities = columns.iter().map(|quantity| dimension_of(*quantity));
        let dimensions = quantities.chain(std::iter::repeat(Dimension::NUMBER));
        cells.iter().zip(dimensions).map(|(cell, unit)| number(cell, unit, [-1e12, 1e12])).collect()
    };
    let rows = items.iter().map(row).collect::<Parsed<_>>()?;
    let history = History { columns: columns.clone(), rows };
    match history.fault() {
        None => Ok(history),
        Some(fault) => Err(wrong(fault)),
    }
}

/// A history as keys of a stage.
pub(super) fn toml(history: &History) -> String {
    let columns: Vec<String> =
        history.columns.iter().map(|quantity| format!("\"{}\"", quantity.name())).collect();
    let row = |row: &Vec<f64>| {
        let cells: Vec<String> = row.iter().map(|x| format_number(x + 0.0)).collect();
        format!("  [{}],\n", cells.join(", "))
    };
    let rows: String = history.rows.iter().map(row).collect();
    format!("columns = [{}]\nrows = [\n{rows}]\n", columns.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<History> {
        read_lines(&mut Lines::new(text.as_bytes(), "element.csv"))
    }

    #[test]
    fn units_stand_in_the_header_and_time_is_no_quantity() {
        let found = read("# an element\ntime,xx_strain (%),yy_stress [kPa]\n0,0,100\n1,0.5,120\n").unwrap();
        assert_eq!(found.columns, [HistoryQuantity::Strain(0), HistoryQuantity::Stress(1)]);
        assert_eq!(found.rows, [[0.0, 100e3], [0.005, 120e3]]);
    }

    #[test]
    fn mistakes_have_line_and_column() {
        for (text, parts) in [
            ("xx_strian\n1\n", &["element.csv:1:1", "did you mean xx_strain?"][..]),
            ("xx_strain,yy_stress (kg)\n1,2\n", &[":1:11", "is a mass", "kPa"]),
            ("xx_strain\n0.1\nx\n", &[":3:1", "is not a number"]),
            ("xx_strain,yy_strain\n0.1\n", &[":2:1", "1 cells", "2 columns"]),
            ("xx_strain\ninf\n", &[":2:1", "is not finite"]),
            ("time,xx_strain\n1,0\n1,0\n", &[":3:1", "does not increase"]),
            ("xx_strain,xx_stress\n0,1\n", &["xx_strain and xx_stress"]),
            ("time\n0\n", &["no column of strains or stresses"]),
            ("xx_strain\n", &["0 rows"]),
        ] {
            let found = read(text).unwrap_err().to_string();
            assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
        }
    }
}
