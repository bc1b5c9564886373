//! The shapes of grains in a case: the section `[grains.shape]`, or tables `[[grains.shape]]` where there are several.

use std::sync::Arc;

use granum_core::quantity::format_number;
use granum_dem::shape::{ShapeDescriptors, ShapeEntry};

use super::definition::Case;
use super::field::{Field, Value};
use super::fields::Fields;
use super::parameters::{CaseParameter, ParameterValue};
use super::shape_value::{SHAPE, only};
use super::suggestion::meant;
use crate::error::{Error, Result};

/// Keys of a table that a section does not have, with their meaning.
pub(super) const OF_TABLE: [[&str; 2]; 4] = [
    [
        "share",
        "Share of the mass of the grains; one may be left out and gets the rest; all are equal if none is given.",
    ],
    ["material", "Name of the material whose grains have this shape; if left out: all."],
    ["smallest", "Smallest diameter of the grains that have this shape; if left out: any."],
    ["largest", "Largest diameter of the grains that have this shape; if left out: any."],
];
/// Key of the file of a mesh or an image, with its meaning.
pub(super) const FILE: [&str; 2] = [
    "file",
    "The file of kind = \"mesh\" (STL, OBJ or PLY) or \"voxels\" (TIFF). The case of a run has the spheres and needs no file.",
];

/// The fields that a shape may have.
pub(super) fn fields(all: &Fields) -> impl Iterator<Item = Arc<Field>> + '_ {
    all.iter().filter(|field| field.section == SHAPE).cloned()
}

/// A case with this shape alone, through which the fields of a case reach it.
fn scratch(case: &Case, entry: &ShapeEntry) -> Case {
    let mut scratch = case.clone();
    let alone = ShapeEntry { share: 1.0, material: None, smallest: None, largest: None, ..entry.clone() };
    scratch.grains.shapes = vec![alone];
    scratch
}

/// Puts the value of a field into a shape.
pub(super) fn put(case: &Case, entry: &mut ShapeEntry, field: &Field, value: Value) {
    let mut scratch = scratch(case, entry);
    field.apply(&mut scratch, value);
    let ShapeEntry { kind, values, spheres, .. } = only(&scratch);
    (entry.kind, entry.values, entry.spheres) = (kind, values, spheres);
}

/// The keys of a table with their values.
fn lines_of(case: &Case, entry: &ShapeEntry) -> Vec<(&'static str, Option<Arc<Field>>, Value)> {
    let alone = scratch(case, entry);
    let mut lines: Vec<(&'static str, Option<Arc<Field>>, Value)> =
        vec![("share", None, Value::Number(Some(entry.share)))];
    for field in fields(&case.fields()) {
        let unused = |value: &Value| matches!(value, Value::Spheres(spheres) if spheres.is_empty());
        if let Some(value) = field.value(&alone).filter(|value| !unused(value)) {
            lines.push((field.key, Some(field), value));
        }
    }
    for (key, value) in [("smallest", entry.smallest), ("largest", entry.largest)] {
        if value.is_some() {
            lines.push((key, None, Value::Number(value)));
        }
    }
    lines
}

fn text_of(field: Option<&Field>, value: &Value) -> String {
    match (field, value) {
        (Some(field), value) => field.toml(value),
        (None, Value::Number(Some(number))) => format_number(*number),
        (None, _) => String::new(),
    }
}

impl Case {
    /// True if the shapes are written as tables: there are several, or one that not all grains have.
    pub(super) fn has_shape_tables(&self) -> bool {
        let whole = |entry: &ShapeEntry| {
            entry.share == 1.0
                && entry.material.is_none()
                && entry.smallest.is_none()
                && entry.largest.is_none()
        };
        self.grains.shapes.len() > 1 || !self.grains.shapes.iter().all(whole)
    }

    /// The tables `[[grains.shape]]` as TOML in SI units; empty where there are none.
    pub fn shapes_toml(&self) -> String {
        let mut text = String::new();
        for entry in self.grains.shapes.iter().filter(|_| self.has_shape_tables()) {
            text.push_str("\n[[grains.shape]]\n");
            for (key, field, value) in lines_of(self, entry) {
                text.push_str(&format!("{key} = {}\n", text_of(field.as_deref(), &value)));
            }
            if let Some(material) = &entry.material {
                text.push_str(&format!("material = \"{material}\"\n"));
            }
        }
        text
    }

    /// The shapes of the grains as a part of a case file: the section `[grains.shape]`, or its tables where there are several.
    pub fn shapes_part(&self) -> String {
        if self.has_shape_tables() {
            return self.shapes_toml().trim_start().to_string();
        }
        let mut text = format!("[{SHAPE}]\n");
        for (key, field, value) in lines_of(self, &only(self)) {
            if key != OF_TABLE[0][0] {
                text.push_str(&format!("{key} = {}\n", text_of(field.as_deref(), &value)));
            }
        }
        text
    }

    /// Keys and values of the tables, for comparisons: `grains.shape.1.kind`.
    pub(super) fn shape_values(&self) -> Vec<(String, String)> {
        let mut values = Vec::new();
        for (k, entry) in self.grains.shapes.iter().enumerate().filter(|_| self.has_shape_tables()) {
            let key = |key: &str| format!("{SHAPE}.{}.{key}", k + 1);
            let lines = lines_of(self, entry);
            values.extend(
                lines.iter().map(|(name, field, value)| (key(name), text_of(field.as_deref(), value))),
            );
            values.extend(entry.material.iter().map(|name| (key("material"), format!("\"{name}\""))));
        }
        values
    }

    /// Descriptors of the shapes of the grains, means by mass, where not all are spheres: their names after `grains.`, their meanings
    /// and values.
    pub(super) fn shape_descriptors(&self) -> Vec<(&'static str, f64)> {
        if self.grains.are_spheres() {
            return Vec::new();
        }
        let mut all: Vec<(ShapeDescriptors, f64)> = Vec::new();
        for entry in &self.grains.shapes {
            let Ok(shapes) = entry.descriptors() else { return Vec::new() };
            all.extend(shapes.iter().map(|shape| (*shape, entry.share / shapes.len() as f64)));
        }
        let mean =
            |value: fn(&ShapeDescriptors) -> f64| all.iter().map(|(shape, share)| share * value(shape)).sum();
        vec![
            ("elongation", mean(|shape| shape.elongation)),
            ("flatness", mean(|shape| shape.flatness)),
            ("sphericity", mean(|shape| shape.sphericity)),
            ("convexity", mean(|shape| shape.convexity)),
            ("roundness", mean(|shape| shape.roundness)),
        ]
    }

    /// The parameters of a run that follow from its shapes: the keys of tables, and the descriptors.
    pub(super) fn shape_parameters(&self) -> Vec<CaseParameter> {
        let mut all = Vec::new();
        for (k, entry) in self.grains.shapes.iter().enumerate().filter(|_| self.has_shape_tables()) {
            for (key, field, value) in lines_of(self, entry) {
                let text = text_of(field.as_deref(), &value);
                let value = match value {
                    Value::Number(Some(number)) => ParameterValue::Number(number),
                    _ => ParameterValue::Word(text.trim_matches('"').to_string()),
                };
                all.push(CaseParameter::new(format!("{SHAPE}.{}.{key}", k + 1), unit(key), value));
            }
        }
        for (name, value) in self.shape_descriptors() {
            all.push(CaseParameter::new(format!("grains.{name}"), "", ParameterValue::Number(value)));
        }
        all
    }

    /// Sets a key of one of several shapes: `grains.shape.2.aspect_ratio`.
    pub(super) fn set_shape(&mut self, path: &str, text: &str) -> Result<()> {
        let wrong =
            |message: String| Error::Value { name: path.to_string(), value: text.to_string(), message };
        let rest = path.strip_prefix(SHAPE).and_then(|rest| rest.strip_prefix('.')).unwrap_or_default();
        let (number, key) = rest.split_once('.').unwrap_or((rest, ""));
        let count = self.grains.shapes.len();
        let place = number.parse::<usize>().ok().filter(|number| (1..=count).contains(number));
        let Some(place) = place.filter(|_| self.has_shape_tables()) else {
            return Err(wrong(match self.has_shape_tables() {
                true => {
                    format!("names a shape that the case does not have; there are {count}, counted from 1")
                }
                false => "needs the tables [[grains.shape]] in the case file".into(),
            }));
        };
        if OF_TABLE.iter().any(|[known, _]| *known == key) || key == FILE[0] {
            return Err(wrong("can only be changed in the case file".into()));
        }
        let all: Vec<Arc<Field>> = fields(&self.fields()).collect();
        let field = all.iter().find(|field| field.key == key).cloned();
        let field = field.ok_or_else(|| {
            wrong(format!("is not one of its keys; {}", meant(key, all.iter().map(|field| field.key))))
        })?;
        let value = field.parse(text).map_err(wrong)?;
        let case = self.clone();
        put(&case, &mut self.grains.shapes[place - 1], &field, value);
        Ok(())
    }
}

fn unit(key: &str) -> &'static str {
    if key == "smallest" || key == "largest" { "m" } else { "" }
}
