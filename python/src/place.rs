//! Where in a case a mistake is: the key of what stands at a position of its text.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Longest text of a value that an exception repeats.
const LONGEST: usize = 80;

/// A value of a case, as the functions of `Case` name it.
#[derive(Debug, Default, PartialEq)]
pub struct Place {
    /// Its key: `grains.count`, `stage.2.axial_strain`, `material.glass.friction`.
    pub key: String,
    /// Its text, if it is no table.
    pub value: Option<String>,
    /// The place in its list, or its row and its column, from 1.
    pub cell: Vec<usize>,
}

/// The place of what stands at a position of a text of TOML, which was read as this document.
pub fn at(text: &str, document: &DeTable<'_>, position: usize) -> Option<Place> {
    Search { text, position }.in_table(document, "")
}

struct Search<'a> {
    text: &'a str,
    position: usize,
}

impl Search<'_> {
    fn is_in<T>(&self, spanned: &Spanned<T>) -> bool {
        spanned.span().contains(&self.position)
    }

    fn in_table(&self, table: &DeTable<'_>, before: &str) -> Option<Place> {
        table.iter().find_map(|(name, value)| {
            let key = joined(before, name.get_ref());
            let inner = self.in_value(value, &key);
            inner.or_else(|| (self.is_in(name) || self.is_in(value)).then(|| self.place(key, value)))
        })
    }

    /// What is found below a value: in a table, in a table of a list, or as an element of a list.
    fn in_value(&self, value: &Spanned<DeValue<'_>>, key: &str) -> Option<Place> {
        match value.get_ref() {
            DeValue::Table(table) => self.in_table(table, key),
            DeValue::Array(items) => items.iter().enumerate().find_map(|(k, item)| match item.get_ref() {
                DeValue::Table(table) => {
                    let key = entry(key, k, table);
                    self.in_table(table, &key).or_else(|| self.is_in(item).then(|| self.place(key, item)))
                }
                _ if self.is_in(item) => Some(self.cell(item, k, key)),
                _ => None,
            }),
            _ => None,
        }
    }

    /// An element of a list, or an element of that.
    fn cell(&self, item: &Spanned<DeValue<'_>>, row: usize, key: &str) -> Place {
        let inner = item.get_ref().as_array().and_then(|inner| {
            let column = inner.iter().position(|inner| self.is_in(inner))?;
            Some((column, &inner[column]))
        });
        match inner {
            Some((column, inner)) => {
                Place { cell: vec![row + 1, column + 1], ..self.place(key.to_string(), inner) }
            }
            None => Place { cell: vec![row + 1], ..self.place(key.to_string(), item) },
        }
    }

    fn place(&self, key: String, value: &Spanned<DeValue<'_>>) -> Place {
        let text = match value.get_ref() {
            DeValue::Table(_) => None,
            DeValue::Array(items) if items.iter().any(|item| item.get_ref().is_table()) => None,
            DeValue::String(text) => Some(short(text)),
            _ => self.text.get(value.span()).map(short),
        };
        Place { key, value: text, cell: Vec::new() }
    }
}

/// The key of an entry of a table. Stages below a stage have only their number.
fn joined(before: &str, name: &str) -> String {
    let is_number = |part: &str| part.parse::<usize>().is_ok();
    let is_in_stage = before.contains(STAGE) && before.rsplit('.').next().is_some_and(is_number);
    match (before, name) {
        ("", _) => name.to_string(),
        (_, STAGE) if is_in_stage => before.to_string(),
        _ => format!("{before}.{name}"),
    }
}

const STAGE: &str = "stage";

/// The key of a table of a list: a material has its name, a pair has those of both, and others have their number.
fn entry(key: &str, number: usize, table: &DeTable<'_>) -> String {
    let word = |value: &DeValue<'_>| value.as_str().map(str::to_string);
    let named = match key {
        "material" => table.get("name").and_then(|name| word(name.get_ref())),
        "pair" => table.get("between").and_then(|names| {
            let names = names.get_ref().as_array()?.iter().map(|name| word(name.get_ref()));
            Some(names.collect::<Option<Vec<String>>>()?.join("."))
        }),
        _ => None,
    };
    named.map_or_else(|| format!("{key}.{}", number + 1), |name| format!("{key}.{name}"))
}

/// The beginning of a long text.
pub fn short(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_string(),
    }
}
