//! The failure of a command and its output: readable text with the position in the file, or JSON.

use std::error::Error;
use std::fmt;
use std::io::IsTerminal;
use std::process::ExitCode;

use granum_io::InputError;
use granum_io::safe_text;
use miette::{
    Diagnostic, GraphicalReportHandler, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan,
    SpanContents,
};

use crate::interrupt::INTERRUPTED;
use crate::messages;

/// Any error that ends a command. The operator `?` converts every error type into it.
pub struct Failure(Box<dyn Error + Send + Sync>);

impl<E: Error + Send + Sync + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure(Box::new(error))
    }
}

/// The user stopped the command.
#[derive(Debug, thiserror::Error)]
#[error("interrupted; {left}")]
pub struct Interrupted {
    /// What has been written, and how to continue.
    pub left: String,
}

/// The reader of the output has ended, as `| head` does. The command ends without a message, and successfully.
#[derive(Debug, thiserror::Error)]
#[error("the output is not read to its end")]
pub struct Unread;

/// A failure that consists of a sentence only.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Sentence(String);

impl Failure {
    /// A failure that consists of a sentence only.
    pub fn new(message: impl Into<String>) -> Failure {
        Sentence(message.into()).into()
    }

    /// True if the user stopped the command.
    pub fn is_interruption(&self) -> bool {
        self.0.is::<Interrupted>()
    }

    /// Prints the failure to standard error, as text or as JSON with the warnings before it, and returns the exit status.
    pub fn print(&self, json: bool, warnings: &[String]) -> ExitCode {
        if self.0.is::<Unread>() {
            return ExitCode::SUCCESS;
        }
        if json {
            messages::line(self.json(warnings));
        } else {
            messages::write(&self.text(std::io::stderr().is_terminal()));
        }
        let status = if self.is_interruption() { INTERRUPTED } else { 1 };
        ExitCode::from(status)
    }

    /// The positions in files to which the error, or one of its causes, refers.
    fn places(&self) -> &[InputError] {
        let mut error: Option<&(dyn Error + 'static)> = Some(self.0.as_ref());
        while let Some(current) = error {
            if let Some(ours) = current.downcast_ref::<granum_io::Error>() {
                return ours.inputs();
            }
            error = current.source();
        }
        &[]
    }

    /// The message, followed by the messages of those causes that it does not already contain.
    pub fn message(&self) -> String {
        let mut text = self.0.to_string();
        let mut cause = self.0.source();
        while let Some(error) = cause {
            let more = error.to_string();
            if !text.contains(&more) {
                text = format!("{text}: {more}");
            }
            cause = error.source();
        }
        text
    }

    /// The failure as readable text. If `drawn`, the lines of the file with the errors are shown; otherwise there is one
    /// line for each position, in a form that editors and search tools understand.
    fn text(&self, drawn: bool) -> String {
        let places = self.places();
        if places.is_empty() {
            return format!("error: {}\n", safe_text::terminal(&self.message()));
        }
        let handler = GraphicalReportHandler::new();
        let mut text = String::new();
        for place in places {
            let drawn = drawn && !place.source_text.is_empty();
            if !drawn || handler.render_report(&mut text, &Drawn(&safe(place))).is_err() {
                text.push_str(&format!("error: {}\n", safe_text::terminal(&place.to_string())));
            }
        }
        text
    }

    /// Prints the error of an invalid command line as JSON.
    pub fn print_usage_as_json(error: &clap::Error) {
        let told = error.render().to_string();
        // An empty line separates the usage and the final hint from the message.
        let lines = told.lines().map(str::trim).filter(|line| !line.is_empty());
        let (usage, message): (Vec<&str>, Vec<&str>) = lines
            .filter(|line| !line.starts_with("For more information"))
            .partition(|line| line.starts_with("Usage:"));
        let message = message.join(" ").replace(" tip: ", "; ");
        let error = serde_json::json!({
            "message": message.strip_prefix("error: ").unwrap_or(&message),
            "usage": usage.first().map(|line| line.trim_start_matches("Usage:").trim()),
            "places": [],
        });
        messages::line(serde_json::json!({ "error": error, "warnings": [] }));
    }

    fn json(&self, warnings: &[String]) -> serde_json::Value {
        let place = |place: &InputError| {
            serde_json::json!({
                "file": place.file,
                "line": place.line,
                "column": place.column,
                "message": place.message,
                "help": place.help,
            })
        };
        let places: Vec<_> = self.places().iter().map(place).collect();
        serde_json::json!({ "error": { "message": self.message(), "places": places }, "warnings": warnings })
    }
}

/// A position whose texts can be drawn on a terminal, whatever the file and its name hold.
fn safe(place: &InputError) -> InputError {
    InputError {
        file: safe_text::line(&place.file).into_owned(),
        message: safe_text::terminal(&place.message).into_owned(),
        help: place.help.as_ref().map(|help| safe_text::terminal(help).into_owned()),
        source_text: safe_text::of_same_length(&place.source_text).into(),
        ..place.clone()
    }
}

/// A position in a file in the form that miette draws.
#[derive(Debug)]
struct Drawn<'a>(&'a InputError);

impl fmt::Display for Drawn<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl Error for Drawn<'_> {}

impl Diagnostic for Drawn<'_> {
    fn help(&self) -> Option<Box<dyn fmt::Display + '_>> {
        let help = self.0.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        (!self.0.source_text.is_empty()).then_some(self)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        if self.0.source_text.is_empty() {
            return None;
        }
        let span = self.0.span.clone();
        Some(Box::new(std::iter::once(LabeledSpan::new(Some("here".into()), span.start, span.len()))))
    }
}

impl SourceCode for Drawn<'_> {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let text: &str = &self.0.source_text;
        let contents = text.read_span(span, before, after)?;
        // The text may be a single line from the middle of a large file.
        Ok(Box::new(MietteSpanContents::new_named(
            self.0.file.clone(),
            contents.data(),
            *contents.span(),
            contents.line() + self.0.first_line - 1,
            contents.column(),
            contents.line_count(),
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_told_once_drawn_or_in_a_line() {
        let failure =
            Failure::from(granum_io::Case::parse("[grains]\ncount = -5\n", "case.toml").unwrap_err());
        let (drawn, line) = (failure.text(true), failure.text(false));
        assert_eq!(drawn.matches("grains.count = -5").count(), 1, "{drawn}");
        assert_eq!(drawn.matches("case.toml:2:").count(), 1, "{drawn}");
        assert!(drawn.contains("2 |") || drawn.contains("2 │"), "{drawn}");
        assert!(
            line.starts_with("error: case.toml:2:9: grains.count = -5") && line.lines().count() == 1,
            "{line}"
        );
    }
}
