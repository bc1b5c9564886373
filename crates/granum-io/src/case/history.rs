//! Histories of strains and stresses for the path `history`: from a CSV file, or as columns and rows of the case itself.
//!
//! The case of a run contains the rows, so that the run no longer needs the file.

use std::path::Path;

use granum_dem::loading::{History, HistoryQuantity, MOST_ROWS};
use toml::de::DeValue;

use super::doubt::Doubt;
use super::stage_values::{Mistake, Node, Parsed, number, text};
use super::suggestion::meant;
use super::unit::dimension;
use crate::error::{Error, Result};
use crate::sheet::{Sheet, Sought, plain, signs, split};
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// Keys of a stage that give a history.
pub(super) const HISTORY_KEYS: [&str; 3] = ["file", "columns", "rows"];

/// The column of times, which the loading does not use.
const TIME: &str = "time";

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

/// Reads a file. Its values are as they stand there, but for columns whose sign of compression a comment states.
///
/// # Errors
/// If it cannot be read; [`Error::Input`] with line and column for what is wrong in it.
pub(super) fn read(path: &Path) -> Result<History> {
    with_header(|sought| history(&Sheet::open(path, sought)?))
}

/// True if comments of a file state the signs of compression.
///
/// # Errors
/// As for [`read`].
pub(super) fn states_signs(path: &Path) -> Result<bool> {
    with_header(|sought| {
        Ok(Sheet::open(path, sought)?.comments().any(|(_, text)| signs::of_comment(text).is_some()))
    })
}

/// Refuses a file if the largest value of a column whose name has no unit is in doubt.
///
/// # Errors
/// As for [`read`]; [`Error::Input`] at the name of the column.
pub(super) fn check_bare(
    path: &Path,
    mut doubt: impl FnMut(HistoryQuantity, f64) -> Option<Doubt>,
) -> Result<()> {
    let sheet = with_header(|sought| Sheet::open(path, sought))?;
    let history = history(&sheet)?;
    let columns = header(&sheet)?;
    let quantities =
        columns.iter().enumerate().filter_map(|(at, column)| Some((at, column, column.quantity?)));
    for (k, (at, column, quantity)) in quantities.enumerate() {
        let larger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let largest = history.rows.iter().filter_map(|row| row.get(k).copied()).fold(0.0, larger);
        if let Some(doubt) = doubt(quantity, largest).filter(|_| column.is_bare) {
            let name = quantity.name();
            let message = format!("{name} goes to {} and {}", format_number(largest), doubt.message());
            return Err(sheet.header_error(at, message).with_help(doubt.header_help(&name)).into());
        }
    }
    Ok(())
}

fn with_header<T>(read: impl FnOnce(&Sought) -> Result<T>) -> Result<T> {
    let is_name = |cell: &str| {
        let (name, _) = split(cell);
        name == TIME || quantity_named(name).is_some()
    };
    read(&Sought { is_name: &is_name, count: usize::MAX, may_have_units: true })
}

fn history(sheet: &Sheet) -> Result<History> {
    let places = header(sheet)?;
    let columns = places.iter().filter_map(|place| place.quantity).collect();
    let mut history = History { columns, rows: Vec::new() };
    let mut time = f64::NEG_INFINITY;
    let mut rows = sheet.rows(&(0..places.len()).collect::<Vec<_>>())?;
    while rows.advance()? {
        let mut row = Vec::with_capacity(places.len());
        for (at, place) in places.iter().enumerate() {
            let name = place.quantity.map_or_else(|| TIME.to_string(), HistoryQuantity::name);
            let value = rows.finite(at, &name)? * place.factor + 0.0;
            match place.quantity {
                Some(_) => row.push(value),
                None if value <= time => {
                    let message = format!("time = {} does not increase from row to row", rows.cell(at));
                    return Err(rows.cell_error(at, message).into());
                }
                None => time = value,
            }
        }
        history.rows.push(row);
        if history.rows.len() > MOST_ROWS {
            return Err(rows.whole_error(format!("the history has more than {MOST_ROWS} rows")).into());
        }
    }
    match history.fault() {
        None => Ok(history),
        Some(fault) => Err(Error::content(Path::new(sheet.file()), fault)),
    }
}

/// The columns that the header names, with the signs that comments state.
fn header(sheet: &Sheet) -> Result<Vec<SourceColumn>> {
    let column = |at: usize| {
        let (name, unit) = sheet.name_and_unit(at)?;
        column(name, unit)
            .map_err(|(message, help)| Error::from(sheet.header_error(at, message).with_help(help)))
    };
    let mut columns: Vec<SourceColumn> = (0..sheet.header().len()).map(column).collect::<Result<_>>()?;
    let stated: Vec<(usize, &str)> =
        sheet.comments().filter_map(|(at, text)| Some((at, signs::of_comment(text)?))).collect();
    for (at, text) in stated {
        let wrong = |message: String| Error::from(sheet.error(at..at, message));
        for (name, is_negative) in signs::signs(text).map_err(wrong)? {
            let quantity = name.as_deref().map(|name| quantity_named(name).ok_or(name));
            let quantity = match quantity.transpose() {
                Ok(quantity) => quantity,
                Err(name) => return Err(wrong(format!("{name} is not a column of a history"))),
            };
            let named = columns.iter_mut().filter(|column| column.quantity.is_some());
            for column in named.filter(|column| quantity.is_none() || column.quantity == quantity) {
                column.factor = column.factor.abs() * if is_negative { -1.0 } else { 1.0 };
            }
        }
    }
    Ok(columns)
}

/// The quantity of a name, or of one that differs in capitals and blanks.
fn quantity_named(name: &str) -> Option<HistoryQuantity> {
    HistoryQuantity::named(name).or_else(|| HistoryQuantity::named(&plain(name)))
}

/// What the name and the unit of a column say, e.g. `xx_stress (kPa)`; what is wrong with it and what would be right.
fn column(name: &str, unit: &str) -> std::result::Result<SourceColumn, (String, String)> {
    if plain(name) == TIME {
        return Ok(SourceColumn { quantity: None, factor: 1.0, is_bare: false });
    }
    let Some(quantity) = quantity_named(name) else {
        let names: Vec<String> = HistoryQuantity::all().map(HistoryQuantity::name).collect();
        let help = meant(name, names.iter().map(String::as_str).chain([TIME]));
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
        with_header(|sought| history(&Sheet::read(text.as_bytes(), "element.csv", sought)?))
    }

    #[test]
    fn units_stand_in_the_header_and_time_is_no_quantity() {
        let found = read("# an element\ntime,xx_strain (%),yy_stress [kPa]\n0,0,100\n1,0.5,120\n").unwrap();
        assert_eq!(found.columns, [HistoryQuantity::Strain(0), HistoryQuantity::Stress(1)]);
        assert_eq!(found.rows, [[0.0, 100e3], [0.005, 120e3]]);
    }

    #[test]
    fn files_of_offices_are_read_with_their_signs() {
        let text = "Versuch;12\n# compression xx_strain = negative;;\nTime;XX strain;yy_stress\ns;%;kPa\n0;0;100\n1;-0,5;120,5\n";
        let found = read(text).unwrap();
        assert_eq!(found.columns, [HistoryQuantity::Strain(0), HistoryQuantity::Stress(1)]);
        assert_eq!(found.rows, [[0.0, 100e3], [0.005, 120.5e3]]);
        let all = read(&text.replace("compression xx_strain", "compression")).unwrap();
        assert_eq!(all.rows, [[0.0, -100e3], [0.005, -120.5e3]]);
        let said = read(&text.replace("compression xx_strain", "compression q")).unwrap_err().to_string();
        assert!(said.contains("element.csv:2:1: q is not a column of a history"), "{said}");
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
