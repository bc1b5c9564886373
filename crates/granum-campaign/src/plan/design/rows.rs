//! The rows of a CSV file as a design: a line with the names of variables, and a line for each point.

use std::path::Path;

use granum_core::input::read_text;
use granum_io::shell::ShowPath;
use granum_io::{Error, InputError, Result};

use super::super::definition::{PlanRow, RowPlace};

/// A larger file is something else.
const LARGEST_FILE: u64 = 1 << 26;

/// Reads the rows of a CSV file.
///
/// # Errors
/// If the file cannot be read, has no rows, or a row has more or fewer cells than the first line; the message names the line.
pub(in crate::plan) fn read_csv(path: &Path) -> Result<Vec<PlanRow>> {
    let text = read_text(path, LARGEST_FILE).map_err(Error::file("read", path))?;
    let file = path.shown();
    let mut lines = text.lines().enumerate().filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let wrong = |number: usize, line: &str, message: String| {
        Error::from(InputError::in_line(&file, number + 1, line, 0..line.len(), message))
    };
    let Some((number, first)) = lines.next() else {
        return Err(Error::content(path, "has no line with the names of variables"));
    };
    let names = cells(first).map_err(|why| wrong(number, first, why))?;
    let mut rows = Vec::new();
    for (number, line) in lines {
        let cells = cells(line).map_err(|why| wrong(number, line, why))?;
        if cells.len() != names.len() {
            let message =
                format!("this row has {} cells, and the first line has {} names", cells.len(), names.len());
            return Err(wrong(number, line, message));
        }
        let place = RowPlace::Csv { file: file.clone(), line: number + 1, text: line.to_string() };
        rows.push(PlanRow { cells: names.iter().cloned().zip(cells).collect(), place });
    }
    if rows.is_empty() {
        return Err(Error::content(path, "has no rows below the names of variables"));
    }
    Ok(rows)
}

/// The cells of a line; a cell in quotes may have commas, and doubled quotes for quotes.
fn cells(line: &str) -> std::result::Result<Vec<String>, String> {
    let mut found = Vec::new();
    let mut rest = line.trim_end_matches('\r');
    loop {
        let begin = rest.trim_start();
        let (cell, after) = match begin.strip_prefix('"') {
            Some(inner) => {
                let end = end_of_quoted(inner).ok_or("a quote is not closed")?;
                (inner[..end].replace("\"\"", "\""), &inner[end + 1..])
            }
            None => {
                let end = begin.find(',').unwrap_or(begin.len());
                (begin[..end].trim().to_string(), &begin[end..])
            }
        };
        found.push(cell);
        let after = after.trim_start();
        match after.strip_prefix(',') {
            Some(next) => rest = next,
            None if after.is_empty() => return Ok(found),
            None => return Err("a comma is needed after a cell in quotes".into()),
        }
    }
}

/// Where a quoted cell ends: at the first quote that is not doubled.
fn end_of_quoted(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], bytes.get(at + 1)) {
            (b'"', Some(b'"')) => at += 2,
            (b'"', _) => return Some(at),
            _ => at += 1,
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_may_be_quoted() {
        let split = |line: &str| cells(line).unwrap();
        assert_eq!(split("0.2, 50 kPa,hertz"), ["0.2", "50 kPa", "hertz"]);
        assert_eq!(split("\"a, b\",\"say \"\"x\"\"\",,c\r"), ["a, b", "say \"x\"", "", "c"]);
        assert_eq!(cells("\"a").unwrap_err(), "a quote is not closed");
        assert_eq!(cells("\"a\"b").unwrap_err(), "a comma is needed after a cell in quotes");
    }

    #[test]
    fn rows_are_told_by_their_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        std::fs::write(&path, "# drawn by hand\nfriction,pressure\n0.2,50 kPa\n\n0.4,100 kPa\n").unwrap();
        let rows = read_csv(&path).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1].cells[1], ("pressure".into(), "100 kPa".into()));
        assert!(matches!(&rows[1].place, RowPlace::Csv { line: 5, .. }));
        std::fs::write(&path, "friction,pressure\n0.2\n").unwrap();
        let message = read_csv(&path).unwrap_err().to_string();
        assert!(message.contains("runs.csv:2:") && message.contains("has 1 cells"), "{message}");
        std::fs::write(&path, "friction\n").unwrap();
        assert!(read_csv(&path).unwrap_err().to_string().contains("has no rows"));
    }
}
