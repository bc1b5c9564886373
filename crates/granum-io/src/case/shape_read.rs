//! Reads the tables `[[grains.shape]]` of a case file, and the files of meshes and images that it names.

use std::ops::Range;
use std::sync::Arc;

use granum_dem::shape::family::ALL;
use granum_dem::shape::{ShapeEntry, ShapeKind};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::definition::Case;
use super::field::{Field, Value};
use super::reader::{ListError, Reader};
use super::shape::{FILE, OF_TABLE, fields, put};
use super::shape_table::ShapeTable;
use super::shape_value::{SHAPE, only, sphere, spheres_text};
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// A value with its position in the file.
type Node<'a> = Spanned<DeValue<'a>>;

/// The text of a plain number.
fn numbers(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::Float(number) => Some(number.as_str().replace('_', "")),
        DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().replace('_', "")),
        _ => None,
    }
}

/// Smallest share of a shape.
const SMALLEST_SHARE: f64 = 1e-6;

impl Reader<'_> {
    /// Reads `[[grains.shape]]`; mistakes go to the others.
    pub(super) fn shape_tables(&mut self, value: &Node<'_>) -> Vec<ShapeTable> {
        let tables: Vec<(&DeTable<'_>, Range<usize>)> = self.tables(SHAPE, value);
        let mut read = Vec::new();
        for (k, (table, span)) in tables.into_iter().enumerate() {
            let place = format!("{SHAPE}.{}", k + 1);
            let known: Vec<Arc<Field>> = fields(&self.fields).collect();
            let mut others = OF_TABLE.map(|[key, _]| key).to_vec();
            others.push(FILE[0]);
            let values = self.values_of(&place, table, &known, &others);
            let share = self.number_of(&place, table, "share", Dimension::NUMBER, [SMALLEST_SHARE, 1.0]);
            let limits = ["smallest", "largest"]
                .map(|key| self.number_of(&place, table, key, Dimension::LENGTH, [1e-9, 10.0]));
            let material = self.text_of(&place, table, "material").map(|(name, _)| name);
            let file = self.text_of(&place, table, FILE[0]);
            read.push(ShapeTable { place, span, values, share, material, limits, file });
        }
        read
    }

    fn number_of(
        &mut self,
        place: &str,
        table: &DeTable<'_>,
        key: &str,
        dimension: Dimension,
        [low, high]: [f64; 2],
    ) -> Option<f64> {
        let node = table.get(key)?;
        let text = match node.get_ref() {
            DeValue::String(text) => text.to_string(),
            other => numbers(other).unwrap_or_default(),
        };
        let read = parse_quantity(&text, dimension).and_then(|value| {
            let fits = value >= low && value <= high;
            let bounds = format!(
                "is out of bounds; it must be from {} to {}",
                format_number(low),
                format_number(high)
            );
            if fits { Ok(value) } else { Err(bounds) }
        });
        read.map_err(|why| {
            let message = format!("{place}.{key} = {} {why}", self.shown(&node.span()));
            self.error(node.span(), message);
        })
        .ok()
    }

    fn text_of(&mut self, place: &str, table: &DeTable<'_>, key: &str) -> Option<(String, Range<usize>)> {
        let node = table.get(key)?;
        if let DeValue::String(text) = node.get_ref() {
            return Some((text.to_string(), node.span()));
        }
        let message = format!("{place}.{key} = {} must be text", self.shown(&node.span()));
        self.error(node.span(), message);
        None
    }

    /// The key `file` of the section `[grains.shape]`.
    pub(super) fn shape_file(&mut self, value: &Node<'_>) {
        match value.get_ref() {
            DeValue::String(name) => self.file_of_shape = Some((name.to_string(), value.span())),
            _ => {
                let message =
                    format!("{SHAPE}.file = {} must be the name of a file", self.shown(&value.span()));
                self.error(value.span(), message);
            }
        }
    }

    /// The spheres of a shape from a list of lists.
    pub(super) fn spheres(items: &[Node<'_>]) -> Result<Value, ListError> {
        let one = |item: &Node<'_>| match item.get_ref() {
            DeValue::Array(cells) => {
                let texts: Option<Vec<String>> = cells.iter().map(|cell| numbers(cell.get_ref())).collect();
                let texts = texts.unwrap_or_default();
                sphere(&texts.iter().map(String::as_str).collect::<Vec<_>>())
            }
            _ => Err(spheres_text()),
        };
        let numbered =
            |(at, item): (usize, &Node<'_>)| one(item).map_err(|why| (Some((at + 1, item.span())), why));
        items.iter().enumerate().map(numbered).collect::<Result<Vec<_>, _>>().map(Value::Spheres)
    }

    /// Puts the shapes of tables and of files into the case.
    pub(super) fn finish_shapes(&mut self, case: &mut Case, tables: Vec<ShapeTable>) {
        if let Some((name, span)) = self.file_of_shape.take() {
            let entry = only(case);
            case.grains.shapes = self.shapes_of_file(entry, &name, span);
        } else {
            self.written_shapes = case.grains.shapes.clone();
        }
        if tables.is_empty() {
            return;
        }
        let shares = self.shares_of_shapes(&tables);
        let mut entries = Vec::new();
        for (table, share) in tables.into_iter().zip(shares) {
            let ShapeTable { values, material, limits: [smallest, largest], file, .. } = table;
            let mut entry = ShapeEntry { share, material, smallest, largest, ..ShapeEntry::default() };
            for (field, value, _) in values {
                put(case, &mut entry, &field, value);
            }
            match file {
                Some((name, span)) => entries.extend(self.shapes_of_file(entry, &name, span)),
                None => {
                    self.written_shapes.push(entry.clone());
                    entries.push(entry);
                }
            }
        }
        case.grains.shapes = entries;
    }

    /// The shapes of a file, as lists of spheres.
    fn shapes_of_file(&mut self, mut entry: ShapeEntry, name: &str, span: Range<usize>) -> Vec<ShapeEntry> {
        let kind = entry.kind;
        if !kind.family().description().takes_file {
            let message = format!("{SHAPE}.file means nothing with kind = {:?}", kind.name());
            let readers = ALL.iter().filter(|kind| kind.family().description().takes_file);
            let readers: Vec<String> = readers.map(|kind| format!("kind = {:?}", kind.name())).collect();
            self.error(span, message).help = Some(format!("write {}", readers.join(" or ")));
            return vec![entry];
        }
        let made = self.named_file(name).and_then(|path| {
            entry.file = Some(path);
            self.written_shapes.push(entry.clone());
            entry.check().map_err(|error| error.to_string())?;
            kind.family().shapes(&entry).map_err(|error| error.to_string())
        });
        match made {
            Ok(shapes) => {
                let share = entry.share / shapes.len().max(1) as f64;
                let of_list = |spheres: granum_dem::shape::Spheres| ShapeEntry {
                    kind: ShapeKind::PIECES,
                    values: Default::default(),
                    spheres: spheres.into_iter().map(|([x, y, z], radius)| [x, y, z, radius]).collect(),
                    file: None,
                    share,
                    ..entry.clone()
                };
                shapes.into_iter().map(of_list).collect()
            }
            Err(why) => {
                self.error(span, format!("{SHAPE}.file = {name:?} cannot be used: {why}"));
                vec![ShapeEntry { file: None, ..entry }]
            }
        }
    }

    /// The shares of the shapes: those given, the rest for those without in equal parts.
    fn shares_of_shapes(&mut self, tables: &[ShapeTable]) -> Vec<f64> {
        let given: f64 = tables.iter().filter_map(|table| table.share).sum();
        let without = tables.iter().filter(|table| table.share.is_none()).count();
        let rest = 1.0 - given;
        let wrong = if without == 0 { rest.abs() > 1e-9 } else { rest < SMALLEST_SHARE };
        if wrong {
            let last = &tables[tables.len() - 1];
            let message =
                format!("the shares of the shapes sum to {} at {}", format_number(given), last.place);
            self.error(last.span.clone(), message).help =
                Some("they must sum to 1; leave some out, and they get the rest".into());
        }
        let each = rest / without.max(1) as f64;
        tables.iter().map(|table| table.share.unwrap_or(each)).collect()
    }
}
