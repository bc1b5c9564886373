//! Tables that a person hands in: laboratory curves, histories, sieve curves, the rows of a design, the inputs of predictions. One reader
//! takes them all as the programs of laboratories and offices save them.
//!
//! - Cells are separated by commas, semicolons or tabs and may be quoted (RFC 4180, by the crate `csv`); lines that begin with `#` are
//!   comments, blank rows mean nothing.
//! - The text is UTF-8, UTF-16 or Windows-1252, with or without a byte order mark.
//! - Decimals have a point or a comma, one of them in the whole table. What could also be a thousands separator is refused, unless a comment
//!   `# decimal = comma` (or `point`) decides.
//! - Lines before the header are passed over, if the reader knows what names it seeks. A header has a name for each column, each once. A row
//!   of units may follow it, and it may be repeated.
//! - Separators at the end of rows mean nothing.
//!
//! Mistakes are told with line, column and value.

mod cells;
mod column_name;
mod decimal_mark;
mod inputs;
mod layout;
mod marks;
mod number;
mod records;
mod rows;
pub(crate) mod signs;
mod sought;
mod source;
mod text;

use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::path::Path;

use granum_core::names::suggestion;

use crate::error::{Error, InputError, Result};
use crate::shell::ShowPath;

pub use cells::{CellRow, read_cells};
pub(crate) use column_name::{plain, split};
pub use decimal_mark::DecimalMark;
pub use inputs::read_inputs;
pub(crate) use rows::Rows;
pub(crate) use sought::Sought;

use decimal_mark::{Evidence, evidence};
use layout::Layout;
use records::cell_at;
use source::{Source, error_in};
use text::TextFault;

/// A table as text, with its header.
pub(crate) struct Sheet {
    source: Source,
    stated_mark: Option<DecimalMark>,
}

impl Sheet {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read or is no text, and for a header that cannot be one: with line and column.
    pub(crate) fn open(path: &Path, sought: &Sought) -> Result<Sheet> {
        let file = granum_core::input::open(path).map_err(Error::file("read", path))?;
        Sheet::read(BufReader::with_capacity(1 << 16, file), &path.shown(), sought)
    }

    /// Reads text from any reader; `file` is its name for messages.
    ///
    /// # Errors
    /// As for [`Sheet::open`].
    pub(crate) fn read(reader: impl BufRead, file: &str, sought: &Sought) -> Result<Sheet> {
        let text = text::read(reader).map_err(|fault| match fault {
            TextFault::Unreadable(source) => Error::file("read", Path::new(file))(source),
            TextFault::AtLine(line, message) => InputError::in_line(file, line, "", 0..0, message).into(),
        })?;
        let text = match marks::tidied(&text) {
            Ok(tidied) => tidied.unwrap_or(text),
            Err((at, message)) => {
                let span = at..text.len();
                return Err(error_in(file, &text, span, message.into()).into());
            }
        };
        let Layout { separator, header, header_at, rows_at, units } = layout::find(&text, sought);
        let file = file.to_string();
        let source = Source { file, text, separator, header, header_at, rows_at, units };
        let mut sheet = Sheet { source, stated_mark: None };
        if sheet.header().is_empty() {
            let message = "is empty; the first line must name the columns";
            return Err(Error::content(Path::new(sheet.file()), message));
        }
        sheet.stated_mark = sheet.mark_of_comments()?;
        sheet.check_header(sought)?;
        Ok(sheet)
    }

    /// The names of the columns as they stand in the header, without quotes.
    pub(crate) fn header(&self) -> &[String] {
        &self.source.header
    }

    /// Name of the file, for messages.
    pub(crate) fn file(&self) -> &str {
        &self.source.file
    }

    /// Name and unit of a column; the unit may stand in the row below the header.
    ///
    /// # Errors
    /// If header and row have different units.
    pub(crate) fn name_and_unit(&self, column: usize) -> Result<(&str, &str)> {
        let (name, unit) = split(&self.source.header[column]);
        let below = self.source.units.get(column).map_or("", String::as_str);
        if !unit.is_empty() && !below.is_empty() && unit != below {
            let message = format!("the header has the unit {unit} of {name}, and the row below it {below}");
            return Err(self.header_error(column, message).into());
        }
        Ok((name, if unit.is_empty() { below } else { unit }))
    }

    /// The column of a name.
    ///
    /// # Errors
    /// If there is none.
    pub(crate) fn position(&self, name: &str) -> Result<usize> {
        self.source.header.iter().position(|cell| cell == name).ok_or_else(|| {
            let help = suggestion(name, self.source.header.iter().map(String::as_str));
            Error::content(Path::new(&self.source.file), format!("there is no column {name}; {help}"))
        })
    }

    /// The comments with the bytes at which they begin.
    pub(crate) fn comments(&self) -> impl Iterator<Item = (usize, &str)> {
        let has_some = self.source.text.contains('#');
        let ends = self.source.text.match_indices(['\n', '\r']).map(|(at, _)| at + 1);
        // A program of an office quotes a comment that has its separator.
        let is_comment = |at: usize| {
            self.source.text[at..].starts_with('#')
                || (at < self.source.header_at && self.source.text[at..].starts_with("\"#"))
        };
        let comment = move |at: usize| {
            is_comment(at).then(|| (at, self.source.line(at).trim_matches(['"', ';', ',', '\t'])))
        };
        std::iter::once(0).chain(ends).take_while(move |_| has_some).filter_map(comment)
    }

    /// The same with a decimal mark that the caller knows.
    pub(crate) fn with_mark(self, mark: Option<DecimalMark>) -> Sheet {
        Sheet { stated_mark: mark.or(self.stated_mark), ..self }
    }

    /// True if commas separate the cells.
    pub(crate) fn has_commas(&self) -> bool {
        self.source.separator == b','
    }

    /// The comments before the header.
    pub(crate) fn comments_before_header(&self) -> impl Iterator<Item = (usize, &str)> {
        let header_at = self.source.header_at;
        self.comments().take_while(move |(at, _)| *at < header_at)
    }

    /// The rows. The decimal mark is decided by these columns of numbers.
    ///
    /// # Errors
    /// If the mark remains in doubt, and as for [`Rows::advance`].
    pub(crate) fn rows(&self, numbers: &[usize]) -> Result<Rows<'_>> {
        let mark = match self.stated_mark {
            Some(mark) => mark,
            None => self.decimal_mark(numbers)?,
        };
        Ok(Rows::new(&self.source, mark))
    }

    /// An error about a byte range of the text.
    pub(crate) fn error(&self, span: Range<usize>, message: String) -> InputError {
        self.source.error(span, message)
    }

    /// An error about the name of a column.
    pub(crate) fn header_error(&self, column: usize, message: String) -> InputError {
        self.error(cell_at(&self.source.text, self.source.header_at, self.source.separator, column), message)
    }

    /// An error about the header as a whole.
    pub(crate) fn whole_header_error(&self, message: String) -> InputError {
        self.error(
            self.source.header_at..self.source.header_at + self.source.line(self.source.header_at).len(),
            message,
        )
    }

    fn mark_of_comments(&self) -> Result<Option<DecimalMark>> {
        for (at, comment) in self.comments() {
            let Some((key, word)) = comment.trim_start_matches('#').split_once('=') else { continue };
            let word = word.trim();
            if key.trim() == "decimal" {
                let mark = DecimalMark::from_word(word).ok_or_else(|| {
                    self.error(
                        at..at + comment.len(),
                        format!("decimal = {word} is not known; it must be point or comma"),
                    )
                })?;
                return Ok(Some(mark));
            }
        }
        Ok(None)
    }

    /// Refuses names that are numbers, that appear twice, or that are several names.
    fn check_header(&self, sought: &Sought) -> Result<()> {
        let mut seen = HashSet::new();
        for (column, name) in self.source.header.iter().enumerate() {
            let wrong = if name.is_empty() {
                // A column of numbers of rows, as some programs write it first, is no column that is sought.
                if sought.count > 0 {
                    continue;
                }
                "a column has no name".to_string()
            } else if name.parse::<f64>().is_ok() {
                format!("{name} is not a column name: the first line must name the columns")
            } else if !seen.insert(name) {
                format!("two columns have the name {name}")
            } else {
                continue;
            };
            return Err(self.header_error(column, wrong).into());
        }
        Ok(())
    }

    /// The mark on which the numbers of these columns agree.
    fn decimal_mark(&self, numbers: &[usize]) -> Result<DecimalMark> {
        let body = &self.source.text[self.source.rows_at..];
        // Between commas a number has no other mark but a point, unless it is quoted.
        if !body.contains(',') || (self.source.separator == b',' && !body.contains('"')) {
            let is_plain = self.source.separator == b',' || !body.contains('.');
            if is_plain {
                return Ok(DecimalMark::Point);
            }
        }
        let mut certain: [Option<(Range<usize>, String)>; 2] = [None, None];
        let mut open = certain.clone();
        let place = |mark: DecimalMark| usize::from(mark == DecimalMark::Comma);
        let mut rows = Rows::new(&self.source, DecimalMark::Point);
        while rows.advance()? {
            for column in numbers {
                let cell = rows.cell(*column);
                let (list, mark) = match evidence(cell) {
                    Evidence::None => continue,
                    Evidence::Certain(mark) => (&mut certain, mark),
                    Evidence::Open(mark) => (&mut open, mark),
                    Evidence::Thousands => {
                        let name = &self.source.header[*column];
                        let mark = if cell.rfind(',') > cell.rfind('.') {
                            DecimalMark::Comma
                        } else {
                            DecimalMark::Point
                        };
                        return Err(rows.cell_error(*column, number::thousands(name, cell, mark)).into());
                    }
                };
                let first = &mut list[place(mark)];
                if first.is_none() {
                    *first = Some((
                        rows.cell_range(*column),
                        format!("{} = {cell:?}", self.source.header[*column]),
                    ));
                }
            }
        }
        self.agreed(certain, open)
    }

    fn agreed(
        &self,
        certain: [Option<(Range<usize>, String)>; 2],
        open: [Option<(Range<usize>, String)>; 2],
    ) -> Result<DecimalMark> {
        let decide = "add a line \"# decimal = comma\" or \"# decimal = point\" at the beginning of the file";
        let [point, comma] = &certain;
        let mark = match (point, comma) {
            (Some((_, point)), Some((range, comma))) => {
                let message = format!(
                    "{comma} has a comma in its decimals, and elsewhere {point} has a point: a table has one decimal mark"
                );
                return Err(self.error(range.clone(), message).into());
            }
            (Some(_), None) => DecimalMark::Point,
            (None, Some(_)) => DecimalMark::Comma,
            (None, None) => {
                let [point, comma] = &open;
                let Some((range, text)) = comma.as_ref().or(point.as_ref()) else {
                    return Ok(DecimalMark::Point);
                };
                // Between commas a point is no thousands separator.
                if self.source.separator == b',' && comma.is_none() {
                    return Ok(DecimalMark::Point);
                }
                let message = format!(
                    "{text} could be a number with three decimals or a number of thousands, and no other number of the table tells; {decide}, \
                     or write no thousands separators"
                );
                return Err(self.error(range.clone(), message).into());
            }
        };
        if let Some((range, text)) = &open[usize::from(mark == DecimalMark::Point)] {
            let message = format!(
                "{text} has a {} where the other numbers of the table have a {} in their decimals; write numbers without thousands separators",
                mark.other().word(),
                mark.word()
            );
            return Err(self.error(range.clone(), message).into());
        }
        Ok(mark)
    }
}

#[cfg(test)]
mod tests;
