//! The text of a table and how it is laid out.

use std::ops::Range;

use super::text;
use crate::error::InputError;

/// The text of a table and how it is laid out.
pub(super) struct Source {
    pub(super) file: String,
    pub(super) text: String,
    pub(super) separator: u8,
    /// The names of the columns.
    pub(super) header: Vec<String>,
    /// The first byte of the header, and of the row after it, or after the row of units.
    pub(super) header_at: usize,
    pub(super) rows_at: usize,
    /// The row of units; empty if there is none.
    pub(super) units: Vec<String>,
}

impl Source {
    /// The text of the line that begins at a byte.
    pub(super) fn line(&self, start: usize) -> &str {
        let rest = &self.text[start..];
        &rest[..rest.find(['\n', '\r']).unwrap_or(rest.len())]
    }

    /// An error about a byte range of the text.
    pub(super) fn error(&self, span: Range<usize>, message: String) -> InputError {
        error_in(&self.file, &self.text, span, message)
    }
}

/// An error about a byte range of the text of a file; of several lines about what is in the first.
pub(super) fn error_in(file: &str, text: &str, span: Range<usize>, message: String) -> InputError {
    let (number, start, line) = line_at(text, span.start);
    let end = (span.end.max(span.start) - start).min(line.len());
    InputError::in_line(file, number, line, span.start - start..end, message)
}

/// Number, first byte and text of the line in which a byte stands.
fn line_at(text: &str, at: usize) -> (usize, usize, &str) {
    let before = &text.as_bytes()[..at.min(text.len())];
    let start = before.iter().rposition(|byte| matches!(byte, b'\n' | b'\r')).map_or(0, |end| end + 1);
    let rest = &text[start..];
    (text::line_of(text.as_bytes(), at), start, &rest[..rest.find(['\n', '\r']).unwrap_or(rest.len())])
}
