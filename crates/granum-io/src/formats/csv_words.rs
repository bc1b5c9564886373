//! Comma-separated values with columns of words: tables of runs, for instance.
//!
//! A number that is not known is an empty cell; texts are quoted where they need it (RFC 4180). Equal tables give equal bytes.

use std::io::{self, Write};
use std::path::Path;

use crate::safe_text;
use granum_core::{Column, Table};

use super::csv_columns::{wanted, with_header};
use crate::error::Result;
use crate::sheet::Sheet;

/// Writes a table with words.
///
/// # Errors
/// Errors of the writer.
pub(super) fn write_rows(writer: &mut impl Write, table: &Table) -> io::Result<()> {
    let mut line = |cells: Vec<String>| writeln!(writer, "{}", cells.join(","));
    line(table.names().map(quoted).collect())?;
    for row in 0..table.rows() {
        line(table.columns().iter().map(|column| quoted(&column.text(row))).collect())?;
    }
    Ok(())
}

/// A cell of CSV.
fn quoted(text: &str) -> String {
    let text = safe_text::csv(text);
    let is_plain = text.trim() == text && !text.contains([',', '"', '\n', '\r']) && !text.starts_with('#');
    if is_plain { text.into_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

/// Reads the named columns, in that order, or all. A column is one of numbers if each of its cells is a number or empty, otherwise one of
/// words.
///
/// # Errors
/// If the file cannot be read; [`Error::Input`](crate::Error::Input) with its place for a quote that is not closed or a row of another
/// length; [`Error::Content`](crate::Error::Content) for a missing column.
pub(super) fn read(path: &Path, names: Option<&[&str]>) -> Result<Table> {
    with_header(names, |sought| words(&Sheet::open(path, sought)?, names))
}

fn words(sheet: &Sheet, names: Option<&[&str]>) -> Result<Table> {
    let wanted = wanted(sheet, names)?;
    let mut texts: Vec<Vec<String>> = vec![Vec::new(); wanted.len()];
    // Between commas numbers have points, and words may be anything.
    let numbers: &[usize] = if sheet.has_commas() { &[] } else { &wanted };
    let mut rows = sheet.rows(numbers)?.with_all();
    while rows.advance()? {
        for (column, texts) in wanted.iter().zip(&mut texts) {
            let word = rows.word(*column);
            // A decimal comma in a column of numbers; words stay as they are.
            let number = if sheet.has_commas() { String::new() } else { rows.quantity(*column) };
            texts.push(if number.parse::<f64>().is_ok() { number } else { word.to_string() });
        }
    }
    let header = sheet.header();
    Ok(Table::new(wanted.iter().zip(&texts).map(|(at, texts)| column(&header[*at], texts)).collect())?)
}

fn column(name: &str, texts: &[String]) -> Column {
    let number = |text: &String| if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() };
    match texts.iter().map(number).collect::<Option<Vec<f64>>>() {
        Some(numbers) => Column::new(name, "", numbers),
        None => Column::of_words(name, texts.iter().map(|text| safe_text::of_csv(text))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{read_table, read_table_with_words, write_table};

    fn table() -> Table {
        Table::new(vec![
            Column::of_words("name", ["a,b", "say \"x\"", ""]),
            Column::new("stress", "Pa", vec![5e4, f64::NAN, -1e-3]),
        ])
        .unwrap()
    }

    #[test]
    fn words_are_quoted_where_they_need_it_and_come_back() {
        let base = tempfile::tempdir().unwrap();
        for name in ["t.csv", "t.parquet"] {
            let path = base.path().join(name);
            write_table(&path, &table()).unwrap();
            let back = read_table_with_words(&path, Some(&["stress", "name"])).unwrap();
            assert_eq!(back.get("name").unwrap(), table().get("name").unwrap(), "{name}");
            let stress = back.column("stress").unwrap();
            assert!(stress[0] == 5e4 && stress[1].is_nan() && stress[2] == -1e-3, "{name}");
            let error = read_table_with_words(&path, Some(&["nam"])).unwrap_err().to_string();
            assert!(error.contains("did you mean name?"), "{error}");
        }
        let text = std::fs::read_to_string(base.path().join("t.csv")).unwrap();
        assert_eq!(text, "name,stress\n\"a,b\",50000\n\"say \"\"x\"\"\",\n,-0.001\n");
        // A reader of numbers passes over the words of a Parquet file.
        let numbers = read_table(base.path().join("t.parquet")).unwrap();
        assert_eq!(numbers.names().collect::<Vec<_>>(), ["stress"]);
        assert_eq!(numbers.columns()[0].unit, "Pa");
        let error = write_table(base.path().join("t.xls"), &table()).unwrap_err().to_string();
        assert!(error.contains(".csv or .parquet"), "{error}");
    }

    #[test]
    fn mistakes_have_their_place() {
        let message = |text: &str| {
            let read = Sheet::read(text.as_bytes(), "t.csv", &crate::sheet::Sought::NOTHING);
            read.and_then(|sheet| words(&sheet, None)).unwrap_err().to_string()
        };
        assert_eq!(message("a,b\n1,\"x\n"), "t.csv:2:3: the quote is not closed");
        assert_eq!(message("a,b\n\"x\"y,1\n"), "t.csv:2:4: a separator must follow the quoted text");
        assert_eq!(message("a,b\nx\n"), "t.csv:2:1: the row has 1 cells, but the header names 2 columns");
        assert_eq!(message("# no\n"), "t.csv: is empty; the first line must name the columns");
        assert!(message("a,a\n1,2\n").contains("two columns have the name a"));
    }
}
