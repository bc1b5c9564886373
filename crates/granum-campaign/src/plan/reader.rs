//! What has been read of a plan so far, with its mistakes, and how single values are read.

use std::ops::Range;

use granum_core::names::suggestion;
use granum_io::{Error, InputError, Reading, Result};
use toml::Spanned as TomlSpanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::definition::{FixedKey, PlanSource};
use super::units;

/// Most mistakes of a file that are told.
const MOST_MISTAKES: usize = 100;

/// A value of the file with its place.
pub type Node<'a> = TomlSpanned<DeValue<'a>>;

/// Reads the tables of a plan, or of a file that is like one, and collects all mistakes with their places.
pub struct Reader {
    /// The text that is read, with its name.
    pub source: PlanSource,
    /// How files that it names are read.
    pub reading: Reading,
    /// The mistakes so far.
    pub errors: Vec<InputError>,
}

impl Reader {
    /// Reads a whole file by a function that notes mistakes here; it has no result where one of them hides the rest.
    ///
    /// # Errors
    /// [`Error::Inputs`] with all mistakes, in the order of the file; what the function returns if there are none.
    pub fn read<T>(
        source: PlanSource,
        reading: Reading,
        read: impl FnOnce(&mut Reader, &DeTable<'_>) -> Result<Option<T>>,
    ) -> Result<T> {
        let text = source.text.clone();
        let document = DeTable::parse(&text).map_err(|error| {
            let message = format!("this is not TOML: {}", error.message().replace('\n', "; "));
            Error::Inputs(vec![source.error(&error.span().unwrap_or(0..0), message)])
        })?;
        let mut reader = Reader { source, reading, errors: Vec::new() };
        let found = read(&mut reader, document.get_ref());
        reader.errors.sort_by_key(|error| error.span.start);
        match found {
            Ok(Some(found)) if reader.errors.is_empty() => Ok(found),
            Err(error) if reader.errors.is_empty() => Err(error),
            _ => Err(Error::Inputs(reader.errors)),
        }
    }

    /// Notes a mistake with what would be right, unless that is empty. Of very many mistakes the first are told.
    pub fn error(&mut self, span: Range<usize>, message: impl Into<String>, help: &str) {
        if self.errors.len() >= MOST_MISTAKES {
            return;
        }
        let error = self.source.error(&span, message);
        self.errors.push(if help.is_empty() { error } else { error.with_help(help) });
    }

    /// Notes keys of a table that are not known.
    pub fn refuse_unknown(&mut self, table: &DeTable<'_>, known: &[&str], what: &str) {
        for key in table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())) {
            let help = suggestion(key.get_ref(), known.iter().copied());
            self.error(key.span(), format!("{:?} is no key of a {what}", key.get_ref()), &help);
        }
    }

    /// A text.
    pub fn text(&mut self, node: &Node, key: &str) -> Option<String> {
        if let DeValue::String(text) = node.get_ref() {
            return Some(text.to_string());
        }
        self.error(node.span(), format!("{key} must be a text in quotes"), "");
        None
    }

    /// The text of a single value: a number, a word, true or false.
    pub fn scalar(&mut self, node: &Node, key: &str) -> Option<String> {
        match node.get_ref() {
            DeValue::String(text) => Some(text.trim().to_string()),
            DeValue::Float(number) => Some(number.as_str().replace('_', "")),
            DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().replace('_', "")),
            DeValue::Boolean(yes) => Some(yes.to_string()),
            other => {
                let message =
                    format!("{key} must be a number or a text, and not of type {}", other.type_str());
                self.error(node.span(), message, "");
                None
            }
        }
    }

    /// A whole number within bounds; `None` if the table does not have it.
    pub fn count(&mut self, table: &DeTable, key: &str, least: u64, most: u64) -> Option<u64> {
        let node = table.get(key)?;
        let text = self.scalar(node, key)?;
        let count = text.parse().ok().filter(|count| (least..=most).contains(count));
        if count.is_none() {
            self.error(
                node.span(),
                format!("{key} = {text} must be a whole number from {least} to {most}"),
                "",
            );
        }
        count
    }

    /// A list.
    pub fn array<'a>(&mut self, node: &'a Node<'a>, key: &str) -> Option<&'a DeArray<'a>> {
        if let DeValue::Array(items) = node.get_ref() {
            return Some(items);
        }
        self.error(node.span(), format!("{key} must be a list in brackets"), "");
        None
    }

    /// Keys that all runs have: `"grains.count" = 300`, or tables of them.
    pub fn fixed(&mut self, node: &Node) -> Vec<FixedKey> {
        let mut found = Vec::new();
        match node.get_ref() {
            DeValue::Table(table) => self.flatten("", table, &mut found),
            _ => self.error(node.span(), "set must be a table", "write [set] with keys below it"),
        }
        found
    }

    fn flatten(&mut self, place: &str, table: &DeTable, found: &mut Vec<FixedKey>) {
        for (key, node) in table {
            let path = if place.is_empty() {
                key.get_ref().to_string()
            } else {
                format!("{place}.{}", key.get_ref())
            };
            match node.get_ref() {
                DeValue::Table(inner) => self.flatten(&path, inner, found),
                DeValue::Array(items) => {
                    let cells = items.iter().map(|item| self.scalar(item, &path)).collect::<Option<Vec<_>>>();
                    let text = cells.map(|cells| cells.join(","));
                    found.extend(text.map(|text| FixedKey { key: path, text, span: key.span() }));
                }
                _ => {
                    let text = self.scalar(node, &path);
                    found.extend(text.map(|text| FixedKey { key: path, text, span: key.span() }));
                }
            }
        }
    }

    /// A number in the SI unit of a key.
    pub fn number(&mut self, node: &Node, key: &str, unit: &str) -> Option<f64> {
        let text = self.scalar(node, key)?;
        match units::quantity(&text, unit) {
            Ok(number) => Some(number),
            Err(why) => {
                self.error(node.span(), format!("{key} = {text} {why}"), "");
                None
            }
        }
    }
}
