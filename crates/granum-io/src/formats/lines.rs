//! The lines of text files, one after the other, each with a limit to its length.

use std::io::{self, BufRead, BufReader};
use std::path::Path;

use granum_core::input::Input;

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

impl Lines<BufReader<Input>> {
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

    /// An error about bytes of the line.
    pub(crate) fn error(&self, span: std::ops::Range<usize>, message: String) -> InputError {
        InputError::in_line(&self.file, self.number, self.line(), span, message)
    }
}
