//! Lines of words separated by blanks, with errors that name line and word: what the text formats of other programs have in
//! common.

use granum_core::input::Input;
use std::io::BufReader;
use std::path::Path;

use granum_core::assembly::Vector;

use crate::error::{Error, Result};
use crate::formats::lines::Lines;

/// Lines of a file and the words of the present one.
pub(crate) struct Words {
    lines: Lines<BufReader<Input>>,
    /// First byte and end of each word of the line.
    places: Vec<(usize, usize)>,
}

impl Words {
    pub(crate) fn open(path: &Path) -> Result<Words> {
        Ok(Words { lines: Lines::open(path)?, places: Vec::new() })
    }

    /// Advances to the next line; false at the end of the file.
    pub(crate) fn advance(&mut self) -> Result<bool> {
        let more = self.lines.advance()?;
        self.places.clear();
        if more {
            let line = self.lines.line();
            let start = |word: &str| word.as_ptr() as usize - line.as_ptr() as usize;
            self.places.extend(line.split_whitespace().map(|word| (start(word), start(word) + word.len())));
        }
        Ok(more)
    }

    /// Advances to the next line, which must be there: `what` is expected in it.
    pub(crate) fn need(&mut self, what: &str) -> Result<()> {
        if self.advance()? {
            return Ok(());
        }
        Err(self.lines.error(0..0, format!("the file ends where {what} should follow")).into())
    }

    /// Advances to the next line that is not blank; false at the end of the file.
    pub(crate) fn advance_to_text(&mut self) -> Result<bool> {
        while self.advance()? {
            if !self.places.is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    pub(crate) fn line(&self) -> &str {
        self.lines.line()
    }

    /// Number of the present line, from 1.
    pub(crate) fn line_number(&self) -> usize {
        self.lines.number()
    }

    pub(crate) fn file(&self) -> &str {
        self.lines.file()
    }

    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// The word at a place; empty beyond the last.
    pub(crate) fn word(&self, at: usize) -> &str {
        self.places.get(at).map_or("", |(start, end)| &self.line()[*start..*end])
    }

    pub(crate) fn words(&self) -> impl Iterator<Item = &str> {
        self.places.iter().map(|(start, end)| &self.line()[*start..*end])
    }

    /// An error about the whole line.
    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        self.lines.error(0..self.line().len(), message.into()).into()
    }

    /// An error about one word.
    pub(crate) fn word_error(&self, at: usize, message: impl Into<String>) -> Error {
        let span = self.places.get(at).map_or(0..0, |(start, end)| *start..*end);
        self.lines.error(span, message.into()).into()
    }

    /// The finite number at a place; `what` is its name for messages.
    pub(crate) fn number(&self, at: usize, what: &str) -> Result<f64> {
        let word = self.word(at);
        if at >= self.len() {
            return Err(self.error(format!("{what} is missing: the line has {} words", self.len())));
        }
        word.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| {
            let shown: String = word.chars().take(40).collect();
            self.word_error(at, format!("{what} = {shown:?} is no finite number"))
        })
    }

    /// The whole number at a place, zero or positive.
    pub(crate) fn whole(&self, at: usize, what: &str) -> Result<u64> {
        let value = self.number(at, what)?;
        if value >= 0.0 && value.fract() == 0.0 && value < 9e15 {
            return Ok(value as u64);
        }
        Err(self.word_error(at, format!("{what} = {value} is no whole number")))
    }

    /// Three numbers from a place on.
    pub(crate) fn vector(&self, at: usize, what: &str) -> Result<Vector> {
        Ok([self.number(at, what)?, self.number(at + 1, what)?, self.number(at + 2, what)?])
    }

    /// A positive number, e.g. a radius.
    pub(crate) fn positive(&self, at: usize, what: &str) -> Result<f64> {
        let value = self.number(at, what)?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(self.word_error(at, format!("{what} = {value} must be positive")))
    }

    /// A count of rows that follow, bounded so that a damaged file is no reason to ask for all memory.
    pub(crate) fn count(&self, at: usize, what: &str) -> Result<usize> {
        let value = self.whole(at, what)?;
        if value <= 1 << 32 {
            return Ok(value as usize);
        }
        Err(self.word_error(at, format!("{what} = {value} is too large")))
    }
}

/// The lines of the beginning of a file; the last one may be cut.
pub(crate) fn head_lines(head: &[u8]) -> Vec<String> {
    String::from_utf8_lossy(head).lines().map(|line| line.trim().to_string()).collect()
}
