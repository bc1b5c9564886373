//! The rows of a table, one after the other.

use std::ops::Range;
use std::path::Path;

use csv::StringRecord;

use super::column_name::unit_of_cell;
use super::decimal_mark::DecimalMark;
use super::number::{number, with_point};
use super::records::{cell_at, records, start_of_record, trimmed};
use super::source::Source;
use super::text;
use crate::error::{Error, InputError, Result};

/// The rows of a table.
pub(crate) struct Rows<'a> {
    source: &'a Source,
    mark: DecimalMark,
    reader: csv::Reader<&'a [u8]>,
    record: StringRecord,
    /// The first byte and the line of the present record.
    start: usize,
    line: usize,
    /// Where the next record is read from.
    end: usize,
    /// True if rows of empty cells, and rows that are the header again, are rows like others.
    takes_all: bool,
}

impl<'a> Rows<'a> {
    pub(super) fn new(source: &'a Source, mark: DecimalMark) -> Rows<'a> {
        let at = source.rows_at;
        Rows {
            source,
            mark,
            reader: records(&source.text[at..], source.separator),
            record: StringRecord::new(),
            start: at,
            line: text::line_of(source.text.as_bytes(), at),
            end: at,
            takes_all: false,
        }
    }

    /// Also takes rows whose cells are all empty, and rows that are the header again: in a table of words they may be data.
    pub(crate) fn with_all(self) -> Rows<'a> {
        Rows { takes_all: true, ..self }
    }

    /// Advances to the next row; false at the end.
    ///
    /// # Errors
    /// For a row with more or fewer cells than the header, not counting empty ones at its end.
    pub(crate) fn advance(&mut self) -> Result<bool> {
        loop {
            let more = self.reader.read_record(&mut self.record);
            // The text is in memory and is text, so that nothing can fail.
            let more = more.map_err(|why| Error::content(Path::new(&self.source.file), why.to_string()))?;
            let before = self.start;
            self.start = start_of_record(&self.source.text, self.end);
            self.end = self.source.rows_at + self.reader.position().byte() as usize;
            if !more {
                return Ok(false);
            }
            self.line += text::line_ends(self.source.text.as_bytes(), before..self.start);
            let is_blank = self.record.iter().all(|cell| trimmed(cell).is_empty());
            let may_be_blank = self.takes_all && self.record.len() > 1;
            if (is_blank && !may_be_blank) || (!self.takes_all && self.repeats_header()) {
                continue;
            }
            self.check_length()?;
            return Ok(true);
        }
    }

    fn check_length(&self) -> Result<()> {
        let (count, width) = (self.record.len(), self.source.header.len());
        if count == width
            || (count > width && self.record.iter().skip(width).all(|cell| trimmed(cell).is_empty()))
        {
            return Ok(());
        }
        let message = format!("the row has {count} cells, but the header names {width} columns");
        let error = self.whole_error(message);
        let with_commas = self.source.separator == b','
            && count > width
            && self.record.iter().all(|cell| cell.bytes().all(|c| c.is_ascii_digit() || c == b'-'));
        Err(match with_commas {
            true => error
                .with_help("decimal commas cannot be told from commas between cells: separate the cells by semicolons, or write decimal points")
                .into(),
            false => error.into(),
        })
    }

    fn repeats_header(&self) -> bool {
        let header = &self.source.header;
        let repeats = self.record.len() >= header.len()
            && self.record.iter().zip(header).all(|(cell, name)| trimmed(cell) == name);
        // A row of units is repeated with it.
        let units = &self.source.units;
        let repeats_units = !units.is_empty()
            && self.record.len() >= units.len()
            && self
                .record
                .iter()
                .zip(units)
                .all(|(cell, unit)| unit_of_cell(trimmed(cell)).unwrap_or(cell) == unit);
        repeats || repeats_units
    }

    /// Number of the line in which the row begins, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The text of the row.
    pub(crate) fn text(&self) -> &str {
        self.source.line(self.start)
    }

    /// A cell without quotes and without blanks around it.
    pub(crate) fn cell(&self, column: usize) -> &str {
        trimmed(self.record.get(column).unwrap_or(""))
    }

    /// A cell as a word: blanks inside quotes belong to it.
    pub(crate) fn word(&self, column: usize) -> &str {
        let (cell, plain) = (self.record.get(column).unwrap_or(""), self.cell(column));
        if cell == plain {
            return plain;
        }
        let range = self.cell_range(column);
        let is_quoted = range.start > 0 && self.source.text.as_bytes()[range.start - 1] == b'"';
        if is_quoted { cell } else { plain }
    }

    /// A cell that may begin with a number, as `50,5 kPa`: with a decimal point.
    pub(crate) fn quantity(&self, column: usize) -> String {
        with_point(self.cell(column), self.mark)
    }

    /// The number in a cell of the column that is called `name`; `nan` and `inf` count as numbers.
    ///
    /// # Errors
    /// What the cell is.
    pub(crate) fn number(&self, column: usize, name: &str) -> Result<f64> {
        number(name, self.cell(column), self.mark).map_err(|message| self.cell_error(column, message).into())
    }

    /// The number in a cell, which must be finite.
    ///
    /// # Errors
    /// What the cell is.
    pub(crate) fn finite(&self, column: usize, name: &str) -> Result<f64> {
        let value = self.number(column, name)?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.cell_error(column, format!("{name} = {} is not finite", self.cell(column))).into())
    }

    /// The bytes of a cell in the text of the table.
    pub(super) fn cell_range(&self, column: usize) -> Range<usize> {
        cell_at(&self.source.text, self.start, self.source.separator, column)
    }

    /// An error about a cell.
    pub(crate) fn cell_error(&self, column: usize, message: String) -> InputError {
        self.source.error(self.cell_range(column), message)
    }

    /// An error about the row.
    pub(crate) fn whole_error(&self, message: String) -> InputError {
        self.source.error(self.start..self.start + self.text().len(), message)
    }
}
