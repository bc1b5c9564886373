//! The lines of CSV files with their cells, and what a cell can be: a name or a number.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use granum_core::names::suggestion;

use crate::error::{Error, InputError, Result};
use crate::shell::ShowPath;

/// A longer line is not a row of numbers.
const LONGEST_LINE: u64 = 1 << 20;

/// Lines of a text file with their numbers, and with a limit on the length of each.
pub(crate) struct Lines<R> {
    reader: R,
    file: String,
    number: usize,
    line: String,
}

impl Lines<BufReader<File>> {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = granum_core::input::open(path).map_err(Error::file("read", path))?;
        Ok(Lines::new(BufReader::with_capacity(1 << 16, file), &path.shown()))
    }
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(reader: R, file: &str) -> Self {
        Lines { reader, file: file.to_string(), number: 0, line: String::new() }
    }

    /// Advances to the next line; returns false at the end of the file.
    pub(crate) fn advance(&mut self) -> Result<bool> {
        let mut bytes = std::mem::take(&mut self.line).into_bytes();
        bytes.clear();
        self.number += 1;
        let mut bounded = io::Read::take(&mut self.reader, LONGEST_LINE);
        bounded.read_until(b'\n', &mut bytes).map_err(Error::file("read", Path::new(&self.file)))?;
        if bytes.is_empty() {
            return Ok(false);
        }
        if bytes.len() as u64 == LONGEST_LINE {
            return Err(self.error(0..0, format!("the line is longer than {LONGEST_LINE} bytes")).into());
        }
        while matches!(bytes.last(), Some(b'\n' | b'\r')) {
            bytes.pop();
        }
        match String::from_utf8(bytes) {
            Ok(line) => {
                self.line = line;
                Ok(true)
            }
            Err(_) => Err(self.error(0..0, "the line is not UTF-8 text".into()).into()),
        }
    }

    /// The line without a byte order mark.
    pub(crate) fn line(&self) -> &str {
        let mark = if self.number == 1 { '\u{feff}' } else { '\n' };
        self.line.strip_prefix(mark).unwrap_or(&self.line)
    }

    /// Number of the line, from 1.
    pub(crate) fn number(&self) -> usize {
        self.number
    }

    /// Name of the file, for messages.
    pub(crate) fn file(&self) -> &str {
        &self.file
    }

    /// True if the line is blank or a comment.
    pub(crate) fn is_empty(&self) -> bool {
        let line = self.line().trim_start();
        line.is_empty() || line.starts_with('#')
    }

    /// The cells of the line, each with the byte at which it starts.
    pub(crate) fn cells(&self) -> impl Iterator<Item = (usize, &str)> {
        let line = self.line();
        line.split(',').map(move |cell| {
            let trimmed = cell.trim();
            (trimmed.as_ptr() as usize - line.as_ptr() as usize, trimmed)
        })
    }

    /// An error about bytes of the line.
    pub(crate) fn error(&self, span: std::ops::Range<usize>, message: String) -> InputError {
        InputError::in_line(&self.file, self.number, self.line(), span, message)
    }

    /// An error about the cell at `start`.
    pub(crate) fn cell_error(&self, start: usize, cell: &str, message: String) -> InputError {
        self.error(start..start + cell.len(), message)
    }
}

/// The names of columns in the current line.
pub(crate) fn names<R: BufRead>(lines: &Lines<R>) -> Result<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for (start, cell) in lines.cells() {
        let name = cell.trim_matches('"');
        let wrong = if name.is_empty() {
            "a column has no name".to_string()
        } else if name.parse::<f64>().is_ok() {
            format!("{name} is not a column name: the first line must name the columns")
        } else if names.iter().any(|known| known == name) {
            format!("two columns have the name {name}")
        } else if name.contains([';', '\t']) {
            format!("{name:?} is not a column name: cells must be separated by commas")
        } else {
            names.push(name.to_string());
            continue;
        };
        return Err(lines.cell_error(start, cell, wrong).into());
    }
    Ok(names)
}

pub(crate) fn position(file: &str, header: &[String], name: &str) -> Result<usize> {
    header.iter().position(|known| known == name).ok_or_else(|| {
        let help = suggestion(name, header.iter().map(String::as_str));
        Error::content(Path::new(file), format!("there is no column {name}; {help}"))
    })
}

/// The number in a cell; `nan` and `inf` count as numbers, an empty cell does not.
pub(crate) fn number<R: BufRead>(lines: &Lines<R>, column: &str, start: usize, cell: &str) -> Result<f64> {
    cell.parse().map_err(|_| {
        let shown: String = cell.chars().take(40).collect();
        let message = match shown.as_str() {
            "" => format!("the cell of column {column} is empty; a number is needed"),
            _ => format!("{column} = {shown:?} is not a number"),
        };
        lines.cell_error(start, cell, message).into()
    })
}
