//! Errors with files, described so that a user finds the position and learns what would be right.

use crate::shell::ShowPath;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mistake inside a text file: its position, the faulty text and what would be right.
#[derive(Clone, Debug, PartialEq)]
pub struct InputError {
    /// Name of the file as the user gave it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong: key and value.
    pub message: String,
    /// What would be right, if there is a suggestion.
    pub help: Option<String>,
    /// The text of the file, or only the faulty line if the file is large.
    pub source_text: Arc<str>,
    /// Byte range of `source_text` that the error refers to.
    pub span: Range<usize>,
    /// Line number of the first line of `source_text` (1 if it is the whole file).
    pub first_line: usize,
}

impl InputError {
    /// An error about the bytes `span` of the whole text of a file.
    pub fn in_text(file: &str, text: &Arc<str>, span: Range<usize>, message: String) -> Self {
        let start = floor_to_character(text, span.start);
        let end = floor_to_character(text, span.end).max(start);
        let before = &text[..start];
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        InputError {
            file: file.to_string(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message,
            help: None,
            source_text: text.clone(),
            span: start..end,
            first_line: 1,
        }
    }

    /// An error about the bytes `span` of one line of a large file.
    pub fn in_line(file: &str, number: usize, line: &str, span: Range<usize>, message: String) -> Self {
        let mut error = Self::in_text(file, &Arc::from(line), span, message);
        error.line = number;
        error.first_line = number;
        error
    }

    /// The same error with a sentence on what would be right.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Largest character boundary of `text` that is not after `at`.
fn floor_to_character(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)?;
        match &self.help {
            Some(help) => write!(f, "; {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for InputError {}

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An operation of the operating system failed.
    #[error("cannot {action} {}: {source}", path.shown())]
    File {
        /// The attempted action, as a verb: "read", "write".
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// One mistake in a text file.
    #[error("{0}")]
    Input(Box<InputError>),
    /// Several mistakes in one text file.
    #[error("{}", join(.0))]
    Inputs(Vec<InputError>),
    /// A value given outside a file (a flag) is wrong.
    #[error("{name} = {value:?} {message}")]
    Value {
        /// Name of the flag or key.
        name: String,
        /// The given text.
        value: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// Values that are valid by themselves but not in combination.
    #[error("{0}")]
    Rule(String),
    /// A file that is damaged, from another version, or not of the kind that its name indicates.
    #[error("{}: {message}", path.shown())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        message: String,
    },
    /// A table lacks a column, or has columns that do not fit together.
    #[error(transparent)]
    Table(#[from] granum_core::TableError),
    /// The output exists already, and its replacement was not requested.
    #[error("{} exists already; give --force to replace it, or another name", .0.shown())]
    Exists(PathBuf),
    /// A file of a format that holds one instant was to hold several.
    #[error("{}: a file of this format ({format}) holds one instant, and these are {count}", path.shown())]
    Instants {
        /// The file.
        path: PathBuf,
        /// The format.
        format: String,
        /// How many there are.
        count: usize,
    },
    /// Another process is using the folder.
    #[error("{} is in use by another granum process{holder}; wait for it or choose another folder", path.shown())]
    Locked {
        /// The folder.
        path: PathBuf,
        /// The holder of the lock according to the lock file, e.g. " (process 4711)".
        holder: String,
    },
}

impl Error {
    /// An [`Error::File`] for use in `map_err`.
    pub fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.to_path_buf();
        move |source| Error::File { action, path, source }
    }

    /// An [`Error::Content`].
    pub fn content(path: &Path, message: impl Into<String>) -> Error {
        Error::Content { path: path.to_path_buf(), message: message.into() }
    }

    /// The positions in text files that this error refers to (empty for the other kinds).
    pub fn inputs(&self) -> &[InputError] {
        match self {
            Error::Input(error) => std::slice::from_ref(error),
            Error::Inputs(errors) => errors,
            _ => &[],
        }
    }
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        Error::Input(Box::new(error))
    }
}

/// An error about a line of a file, or about the whole file if the line is 0 because the file has no lines.
pub(crate) fn in_file(file: &str, line: usize, message: String, help: &str) -> Error {
    if line == 0 {
        return Error::content(Path::new(file), format!("{message}; {help}"));
    }
    InputError::in_line(file, line, "", 0..0, message).with_help(help).into()
}

fn join(errors: &[InputError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn position_counts_characters_not_bytes() {
        let text: Arc<str> = Arc::from("one\nzwölf = 3\n");
        let at = text.find('3').unwrap();
        let error = InputError::in_text("case.toml", &text, at..at + 1, "no".into());
        assert_eq!((error.line, error.column), (2, 9));
        assert_eq!(error.with_help("yes").to_string(), "case.toml:2:9: no; yes");
    }

    #[test]
    fn a_span_inside_a_character_or_beyond_the_end_does_not_panic() {
        let text: Arc<str> = Arc::from("ö");
        assert_eq!(InputError::in_text("f", &text, 1..9, String::new()).span, 0..2);
    }
}
