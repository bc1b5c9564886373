//! A table of numbers and words as aligned text, or as JSON.

use granum_core::quantity::format_number;
use granum_core::{Column, Table};
use granum_io::safe_text;
use serde_json::{Value, json};

/// Significant digits of numbers.
const DIGITS: usize = 4;
/// The separator of columns.
const GAP: &str = "  ";

/// The rows of a table as objects.
pub fn rows(table: &Table) -> Vec<Value> {
    let cell = |column: &Column, row: usize| match column.numbers() {
        Some(numbers) => json!(numbers.get(row).filter(|value| value.is_finite())),
        None => json!(column.text(row)),
    };
    let object = |row: usize| {
        let cells = table.columns().iter().map(|column| (column.name.clone(), cell(column, row)));
        Value::Object(cells.collect())
    };
    (0..table.rows()).map(object).collect()
}

/// The lines of a table: names, units if there are any, and a line for each row. A long name is broken at its dots and
/// underscores, so that a column is not wider than it must be.
pub fn lines(table: &Table) -> Vec<String> {
    let columns: Vec<Vec<String>> =
        table.columns().iter().map(|column| cells(column, table.rows())).collect();
    let heads: Vec<Vec<String>> = (table.columns().iter().zip(&columns))
        .map(|(column, cells)| {
            broken(
                &safe_text::line(&column.name),
                cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0),
            )
        })
        .collect();
    let height = heads.iter().map(Vec::len).max().unwrap_or(0);
    let has_units = table.columns().iter().any(|column| !column.unit.is_empty());
    // Each column from top to bottom: its name, which ends beside the others, its unit, its values.
    let full: Vec<Vec<String>> = table
        .columns()
        .iter()
        .zip(heads)
        .zip(columns)
        .map(|((column, head), cells)| {
            let mut full = vec![String::new(); height - head.len()];
            full.extend(head);
            full.extend(has_units.then(|| safe_text::line(&column.unit).into_owned()));
            full.extend(cells);
            full
        })
        .collect();
    let widths: Vec<usize> =
        full.iter().map(|cells| cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0)).collect();
    let rows = full.first().map_or(0, Vec::len);
    let line = |row: usize| {
        let cell = |k: usize| {
            let (text, width) = (&full[k][row], widths[k]);
            match table.columns()[k].has_words() {
                false => format!("{text:>width$}"),
                true => format!("{text:<width$}"),
            }
        };
        (0..full.len()).map(cell).collect::<Vec<_>>().join(GAP).trim_end().to_string()
    };
    (0..rows).map(line).collect()
}

fn cells(column: &Column, rows: usize) -> Vec<String> {
    match column.numbers() {
        Some(values) => values.iter().map(|value| number(*value)).collect(),
        None => (0..rows)
            .map(|row| safe_text::line(&column.text(row)).into_owned())
            .map(|text| if text.is_empty() { "-".into() } else { text })
            .collect(),
    }
}

/// A number with four significant digits; a whole number in full.
fn number(value: f64) -> String {
    if value.is_nan() {
        return "-".into();
    }
    if value.fract() == 0.0 && value.abs() < 1e7 {
        return format!("{value}");
    }
    let short = format_number(value);
    if short.len() <= DIGITS + 2 {
        return short;
    }
    let exponent = libm::log10(value.abs()).floor() as i32;
    if !(-4..7).contains(&exponent) {
        return format!("{value:.*e}", DIGITS - 1);
    }
    let decimals = (DIGITS as i32 - 1 - exponent).max(0) as usize;
    format!("{value:.decimals$}")
}

/// A name in pieces of about the given width, each of which keeps the dot or underscore at its end.
fn broken(name: &str, width: usize) -> Vec<String> {
    let width = width.max(10);
    let mut lines = vec![String::new()];
    for part in name.split_inclusive(['.', '_']) {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].chars().count() + part.chars().count() > width {
            lines.push(part.to_string());
        } else {
            lines[last].push_str(part);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_below_their_names_and_units() {
        let table = Table::new(vec![
            Column::of_words("name", ["a", "long-name"]),
            Column::new("stage.1.lateral_stress", "Pa", vec![5e4, 1e5]),
            Column::new("void_ratio", "", vec![2.0 / 3.0, f64::NAN]),
        ])
        .unwrap();
        let wanted = [
            "           stage.1.",
            "           lateral_",
            "name         stress  void_ratio",
            "                 Pa",
            "a             50000      0.6667",
            "long-name    100000           -",
        ];
        assert_eq!(lines(&table), wanted);
    }

    #[test]
    fn numbers_have_four_digits() {
        let shown = [0.123456, 123456.7, 1.5e-7, 1.23456e-7, 3.0, -31.25, 0.2].map(number);
        assert_eq!(shown, ["0.1235", "123457", "1.5e-7", "1.235e-7", "3", "-31.25", "0.2"]);
    }
}
