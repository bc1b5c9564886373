//! What has been read of a case file so far, with its mistakes.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use granum_dem::shape::ShapeEntry;
use toml::de::DeValue;

use super::bond::CaseBond;
use super::case_stage::CaseStage;
use super::field::{Field, Value};
use super::fields::Fields;
use super::material_table::{MaterialTable, PairTable};
use super::reading::Reading;
use super::shape_table::ShapeTable;
use crate::error::InputError;
use crate::named_file::named_file;

/// The text of a single value.
pub(super) fn scalar(field: &Field, value: &DeValue<'_>) -> std::result::Result<String, String> {
    match value {
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Float(number) => Ok(number.as_str().replace('_', "")),
        DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str().replace('_', "")),
        DeValue::Integer(_) => Err("must be written as a decimal number".into()),
        other => Err(format!("is of type {}; it must be {}", other.type_str(), field.bounds_text())),
    }
}

/// A mistake in a list: the number of the wrong value, from 1, and its position in the file, or `None` if it concerns the
/// whole list; and the message.
pub(super) type ListError = (Option<(usize, Range<usize>)>, String);

pub(super) struct Reader<'a> {
    pub(super) file: &'a str,
    /// The folder in which the files lie that the case names.
    pub(super) folder: &'a Path,
    pub(super) reading: Reading,
    /// The keys that a case file can have.
    pub(super) fields: Fields,
    pub(super) text: Arc<str>,
    pub(super) errors: Vec<InputError>,
    /// Position of each key in the file, by path.
    pub(super) keys: HashMap<String, Range<usize>>,
    /// Valid values, by path.
    pub(super) values: HashMap<String, Value>,
    pub(super) stages: Vec<CaseStage>,
    pub(super) preparation_stages: Vec<CaseStage>,
    pub(super) materials: Vec<MaterialTable>,
    pub(super) pairs: Vec<PairTable>,
    pub(super) bonds: Vec<CaseBond>,
    pub(super) shapes: Vec<ShapeTable>,
    /// The file of the section `[grains.shape]`.
    pub(super) file_of_shape: Option<(String, Range<usize>)>,
    /// The shapes as the file has them: those of a mesh or an image with its name in place of spheres.
    pub(super) written_shapes: Vec<ShapeEntry>,
    /// Parameters of sensors that this program does not know, by key.
    pub(super) undeclared_parameters: BTreeMap<String, f64>,
}

impl Reader<'_> {
    pub(super) fn error(&mut self, span: Range<usize>, message: String) -> &mut InputError {
        self.errors.push(InputError::in_text(self.file, &self.text, span, message));
        let last = self.errors.len() - 1;
        &mut self.errors[last]
    }

    /// The file that the case names.
    pub(super) fn named_file(&self, name: &str) -> std::result::Result<PathBuf, String> {
        named_file(self.folder, name, self.reading.outside)
    }

    /// The text of a value, short enough for a message.
    pub(super) fn shown(&self, span: &Range<usize>) -> String {
        let text = self.text.get(span.clone()).unwrap_or_default();
        let line = text.lines().next().unwrap_or_default();
        if line.chars().count() > 60 || text.lines().count() > 1 {
            format!("{}...", line.chars().take(60).collect::<String>())
        } else {
            line.to_string()
        }
    }
}
