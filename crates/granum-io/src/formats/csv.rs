//! Comma-separated values: a line of names, then one line of numbers for each row.
//!
//! Numbers are written as the shortest text that is read back as the same double. Units are not written. What a person hands in may have
//! other separators and marks, which the [`sheet`](crate::sheet) reads.

use std::io::{self, BufRead, Write};
use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::{Error, Result};
use crate::formats::csv_columns::{wanted, with_header};
use crate::formats::csv_words;
use crate::formats::table_format::TableFormat;
use crate::safe_text;
use crate::sheet::Sheet;
use granum_core::quantity::format_number;
use granum_core::{Column, Table};

/// The format.
pub struct Csv;

impl TableFormat for Csv {
    fn name(&self) -> &'static str {
        "CSV"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }
    fn read(&self, path: &Path, names: Option<&[&str]>) -> Result<Table> {
        read(path, names)
    }
    fn read_with_words(&self, path: &Path, names: Option<&[&str]>) -> Result<Table> {
        csv_words::read(path, names)
    }
    fn write(&self, path: &Path, table: &Table) -> Result<()> {
        write(path, table)
    }
}

/// Reads the named columns, in that order, or all.
///
/// # Errors
/// If the file cannot be read; [`Error::Input`] with line and column for a cell that is not a number, a row of another
/// length, a header that is missing or contains a name twice; [`Error::Content`] for a missing column.
pub fn read(path: &Path, names: Option<&[&str]>) -> Result<Table> {
    with_header(names, |sought| numbers(&Sheet::open(path, sought)?, names))
}

/// Reads a table from any reader of text; `file` is its name for messages.
///
/// # Errors
/// As for [`read`].
pub fn read_from(reader: impl BufRead, file: &str, names: Option<&[&str]>) -> Result<Table> {
    with_header(names, |sought| numbers(&Sheet::read(reader, file, sought)?, names))
}

fn numbers(sheet: &Sheet, names: Option<&[&str]>) -> Result<Table> {
    let wanted = wanted(sheet, names)?;
    let header = sheet.header();
    let mut values = vec![Vec::new(); wanted.len()];
    let mut rows = sheet.rows(&wanted)?;
    while rows.advance()? {
        for (column, values) in wanted.iter().zip(&mut values) {
            values.push(rows.number(*column, &header[*column])?);
        }
    }
    let name = |at: usize| safe_text::of_csv(&header[at]);
    let columns = wanted.iter().zip(values).map(|(at, values)| Column::new(name(*at), "", values)).collect();
    Ok(Table::new(columns)?)
}

/// Writes a table under a temporary name and renames it. In a table with words a number that is not known is an empty cell, in one of
/// numbers it is `nan`.
///
/// # Errors
/// [`Error::Rule`] if a name could not be read back (a comma, a quote, a number); [`Error::File`] if the file cannot be
/// written.
pub fn write(path: &Path, table: &Table) -> Result<()> {
    if table.has_words() {
        return write_atomically(path, |file| csv_words::write_rows(file, table));
    }
    check_names(table).map_err(Error::Rule)?;
    write_atomically(path, |file| write_rows(file, table))
}

/// Writes a table to any writer, e.g. the standard output.
///
/// # Errors
/// Errors of the writer; [`io::ErrorKind::InvalidInput`] if a name could not be read back.
pub fn write_rows(writer: &mut impl Write, table: &Table) -> io::Result<()> {
    if table.has_words() {
        return csv_words::write_rows(writer, table);
    }
    check_names(table).map_err(|why| io::Error::new(io::ErrorKind::InvalidInput, why))?;
    let names: Vec<_> = table.names().map(safe_text::csv).collect();
    writeln!(writer, "{}", names.join(","))?;
    let mut line = String::new();
    for row in 0..table.rows() {
        line.clear();
        for (at, column) in table.columns().iter().enumerate() {
            if at > 0 {
                line.push(',');
            }
            line.push_str(&format_number(column.values[row]));
        }
        line.push('\n');
        writer.write_all(line.as_bytes())?;
    }
    Ok(())
}

fn check_names(table: &Table) -> std::result::Result<(), String> {
    let unfit = |name: &&str| {
        name.contains([',', '"', '\n', '\r', ';', '\t'])
            || name.starts_with(['#', '\u{feff}'])
            || name.trim() != *name
            || name.parse::<f64>().is_ok()
    };
    match table.names().find(unfit) {
        Some(name) => Err(format!("a CSV file cannot hold a column named {name:?}")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Table> {
        read_from(text.as_bytes(), "t.csv", None)
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn reads_comments_quotes_marks_and_line_ends() {
        let table = parse("\u{feff}# a comment\r\n\"a\", b\r\n1,-2e-3\r\n\r\n nan ,inf\r\n").unwrap();
        assert_eq!(table.column("b").unwrap(), [-2e-3, f64::INFINITY]);
        assert!(table.column("a").unwrap()[1].is_nan());
    }

    #[test]
    fn mistakes_have_their_place() {
        assert_eq!(message("a,b\n1,2\n3,x4\n"), "t.csv:3:3: b = \"x4\" is not a number");
        assert_eq!(message("a,b\n1,\n"), "t.csv:2:3: the cell of column b is empty; a number is needed");
        assert_eq!(message("a,b\n1\n"), "t.csv:2:1: the row has 1 cells, but the header names 2 columns");
        assert_eq!(
            message("1,2\n"),
            "t.csv:1:1: 1 is not a column name: the first line must name the columns"
        );
        assert_eq!(message("a,a\n"), "t.csv:1:3: two columns have the name a");
        assert_eq!(
            message("a,b,\n1,1,2\n"),
            "t.csv:2:1: the row has 3 cells, but the header names 2 columns; decimal commas cannot be told from commas between \
             cells: separate the cells by semicolons, or write decimal points"
        );
        assert_eq!(message("a,,b\n1,1,2\n"), "t.csv:1:3: a column has no name");
        assert_eq!(message("# nothing\n"), "t.csv: is empty; the first line must name the columns");
        let not_text = read_from(&b"a\n\xff\n"[..], "t.csv", None).unwrap_err().to_string();
        assert_eq!(not_text, "t.csv:2:1: a = \"ÿ\" is not a number");
    }

    #[test]
    fn a_line_without_end_is_refused_and_not_held() {
        let endless = io::Read::chain(&b"a\n"[..], io::repeat(b'1'));
        let error = read_from(io::BufReader::new(endless), "t.csv", None).unwrap_err().to_string();
        assert!(error.contains("the line is longer"), "{error}");
    }

    #[test]
    fn wanted_columns_come_in_the_order_asked_for() {
        let table = read_from("a,b,c\n1,2,x\n".as_bytes(), "t.csv", Some(&["b", "a"])).unwrap();
        assert_eq!(table.names().collect::<Vec<_>>(), ["b", "a"]);
        let error = read_from("strain,b\n".as_bytes(), "t.csv", Some(&["strian"])).unwrap_err().to_string();
        assert_eq!(error, "t.csv: there is no column strian; did you mean strain?");
    }

    #[test]
    fn a_name_that_would_not_read_back_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let table = Table::new(vec![Column::new("a,b", "", vec![])]).unwrap();
        assert!(write(&folder.path().join("x.csv"), &table).is_err());
        // A byte order mark is no part of a name, wherever it stands.
        let read = parse("# units follow\n\u{feff}a\n").unwrap();
        assert_eq!(read.names().collect::<Vec<_>>(), ["a"]);
    }

    proptest! {
        #[test]
        fn numbers_survive_bit_for_bit(bits in proptest::collection::vec(any::<(u64, u64)>(), 0..20)) {
            let column = |pick: fn(&(u64, u64)) -> u64| bits.iter().map(|b| f64::from_bits(pick(b))).collect();
            let table = Table::new(vec![
                Column::new("a", "", column(|b| b.0)),
                Column::new("b", "", column(|b| b.1)),
            ]).unwrap();
            let mut text = Vec::new();
            write_rows(&mut text, &table).unwrap();
            let back = read_from(&text[..], "t.csv", None).unwrap();
            for (ours, theirs) in table.columns().iter().zip(back.columns()) {
                for (x, y) in ours.values.iter().zip(&theirs.values) {
                    prop_assert!(x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan()));
                }
            }
        }

        #[test]
        fn any_bytes_give_a_table_or_a_message(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
            let _ = read_from(&bytes[..], "t.csv", None);
        }
    }
}
