//! Records of a text by the crate `csv`, and where they and their cells stand in it.

use std::ops::Range;

use csv::ReaderBuilder;

/// A reader of the records of a text, of which none is taken for a header.
pub(super) fn records(text: &str, separator: u8) -> csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(separator)
        .from_reader(text.as_bytes())
}

/// Where a record begins that was read from `at`: after blank lines and comments.
pub(super) fn start_of_record(text: &str, mut at: usize) -> usize {
    loop {
        let rest = &text[at..];
        if rest.starts_with(['\n', '\r']) {
            at += 1;
        } else if rest.starts_with('#') {
            at += rest.find(['\n', '\r']).unwrap_or(rest.len());
        } else {
            return at;
        }
    }
}

/// A cell without blanks around it, and without byte order marks, which files that were put together have inside.
pub(super) fn trimmed(cell: &str) -> &str {
    cell.trim_matches(|c: char| c.is_whitespace() || matches!(c, '\u{feff}' | '\u{200b}'))
}

/// The bytes of a cell of the record that begins at `start`, without its quotes; empty beyond the last cell.
pub(super) fn cell_at(text: &str, start: usize, separator: u8, cell: usize) -> Range<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut begin, mut number, mut in_quotes) = (start, start, 0, false);
    loop {
        let byte = bytes.get(at).copied();
        match byte {
            Some(b'"') if in_quotes || at == begin => in_quotes = !in_quotes,
            Some(byte) if in_quotes || !(byte == separator || matches!(byte, b'\n' | b'\r')) => {}
            _ if number == cell => {
                let inside = trimmed(&text[begin..at]);
                let inside =
                    inside.strip_prefix('"').and_then(|inside| inside.strip_suffix('"')).unwrap_or(inside);
                let first = inside.as_ptr() as usize - text.as_ptr() as usize;
                return first..first + inside.len();
            }
            Some(byte) if byte == separator => (number, begin) = (number + 1, at + 1),
            _ => return at..at,
        }
        at += 1;
    }
}
