//! The stresses and strains of a case file, and of flags, that are given as numbers without a unit and are in doubt ([`super::doubt`]).
//!
//! What granum writes of a case has units where a number would be in doubt, and is read back wherever it is copied to.

use std::ops::Range;
use std::path::Path;

use granum_core::quantity::{Dimension, format_number, parse_quantity};
use granum_dem::loading::Measure;
use granum_dem::loading::preset::{PathParameterKind, Paths};
use granum_dem::servo::COMPONENTS;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::definition::Case;
use super::doubt::{Doubt, Known, NumberKind, is_bare};
use super::history::{self, HISTORY_KEYS};
use super::stage_values::{Node, scalar};
use crate::error::{Error, Result};

/// A number of a case file.
struct Found {
    /// What is shown of its key, e.g. `stage.1.lateral_stress`.
    name: String,
    kind: NumberKind,
    text: String,
    span: Range<usize>,
    /// The numbers of one column of a history are judged by the largest of them.
    column: Option<usize>,
}

/// Collects the stresses and strains of a case file.
struct Finder<'p> {
    paths: &'p Paths,
    found: Vec<Found>,
    columns: usize,
    /// Histories in files: their names, and where they stand.
    files: Vec<(String, Range<usize>)>,
}

impl Finder<'_> {
    fn new(paths: &Paths) -> Finder<'_> {
        Finder { paths, found: Vec::new(), columns: 0, files: Vec::new() }
    }

    fn number(&mut self, name: String, kind: NumberKind, value: &Node<'_>, column: Option<usize>) {
        if let Ok(text) = scalar(value) {
            self.found.push(Found { name, kind, text, span: value.span(), column });
        }
    }

    /// A value by its key in a table, or each value of a list.
    fn key(&mut self, table: &DeTable<'_>, name: &str, key: &str, kind: NumberKind) {
        match table.get(key).map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Array(items))) => {
                for item in items {
                    self.number(format!("{name}.{key}"), kind, item, None);
                }
            }
            Some((value, _)) => self.number(format!("{name}.{key}"), kind, value, None),
            None => {}
        }
    }

    fn document(&mut self, table: &DeTable<'_>) {
        for section in ["preparation", "shear"] {
            let Some(DeValue::Table(inner)) = table.get(section).map(Spanned::get_ref) else { continue };
            for key in inner.keys() {
                if let Some(kind) = NumberKind::of_field(&format!("{section}.{}", key.get_ref())) {
                    self.key(inner, section, key.get_ref(), kind);
                }
            }
            if let Some(stages) = inner.get("stage") {
                self.stages(stages, &format!("{section}.stage"));
            }
        }
        if let Some(stages) = table.get("stage") {
            self.stages(stages, "stage");
        }
    }

    fn stages(&mut self, stages: &Node<'_>, name: &str) {
        let DeValue::Array(items) = stages.get_ref() else { return };
        for (k, item) in items.iter().enumerate() {
            let DeValue::Table(table) = item.get_ref() else { continue };
            let name = format!("{name}.{}", k + 1);
            match (table.get("path").map(Spanned::get_ref), table.get("stage")) {
                (Some(DeValue::String(path)), _) => self.path(table, &name, path),
                (_, Some(inner)) => self.stages(inner, &name),
                _ => self.control(table, &name),
            }
        }
    }

    fn path(&mut self, table: &DeTable<'_>, name: &str, path: &str) {
        let Some(preset) = self.paths.named(path) else { return };
        for parameter in preset.parameters() {
            if let Some(kind) = NumberKind::of_parameter(parameter) {
                self.key(table, name, parameter.key, kind);
            }
        }
        if preset.parameters().any(|parameter| parameter.kind == PathParameterKind::History) {
            self.history(table, name);
        }
    }

    fn history(&mut self, table: &DeTable<'_>, name: &str) {
        let [file, columns, rows] = HISTORY_KEYS.map(|key| table.get(key));
        if let Some((file, DeValue::String(text))) = file.map(|file| (file, file.get_ref())) {
            self.files.push((text.to_string(), file.span()));
        }
        let quantities = columns.and_then(|columns| history::columns(columns).ok());
        let (Some(quantities), Some(DeValue::Array(rows))) = (quantities, rows.map(Spanned::get_ref)) else {
            return;
        };
        for row in rows {
            let DeValue::Array(cells) = row.get_ref() else { continue };
            for ((k, cell), quantity) in cells.iter().enumerate().zip(&quantities) {
                let name = format!("{name}.rows ({})", quantity.name());
                self.number(name, NumberKind::of_quantity(*quantity), cell, Some(self.columns + k));
            }
        }
        self.columns += quantities.len();
    }

    /// A stage with an explicit control.
    fn control(&mut self, table: &DeTable<'_>, name: &str) {
        for component in COMPONENTS {
            let Some(DeValue::Table(drive)) = table.get(component).map(Spanned::get_ref) else { continue };
            let name = format!("{name}.{component}");
            for key in ["stress", "stress_to", "stress_by"] {
                self.key(drive, &name, key, NumberKind::Stress);
            }
            for key in ["strain_to", "strain_by"] {
                self.key(drive, &name, key, NumberKind::Strain);
            }
        }
        if let Some(DeValue::Array(items)) = table.get("constraint").map(Spanned::get_ref) {
            for (k, item) in items.iter().enumerate() {
                // Values are given for combinations of stresses only.
                let DeValue::Table(constraint) = item.get_ref() else { continue };
                for key in ["value", "value_to", "value_by"] {
                    self.key(constraint, &format!("{name}.constraint.{}", k + 1), key, NumberKind::Stress);
                }
            }
        }
        if let Some(DeValue::Table(until)) = table.get("until").map(Spanned::get_ref) {
            self.ends(until, &format!("{name}.until"));
        }
        if let Some(DeValue::Table(turns)) = table.get("turns").map(Spanned::get_ref) {
            self.measured(turns, &format!("{name}.turns"), &["high", "low"]);
        }
    }

    fn ends(&mut self, until: &DeTable<'_>, name: &str) {
        for (_, _, measure) in Measure::ALL {
            if let Some(kind) = NumberKind::of_measure(measure) {
                self.key(until, name, measure.name(), kind);
            }
        }
        if let Some(DeValue::Table(inner)) = until.get("double_amplitude").map(Spanned::get_ref) {
            self.measured(inner, &format!("{name}.double_amplitude"), &["value"]);
        }
    }

    /// Values of the measure that the table names.
    fn measured(&mut self, table: &DeTable<'_>, name: &str, keys: &[&str]) {
        let Some(DeValue::String(measure)) = table.get("measure").map(Spanned::get_ref) else { return };
        if let Some(kind) = Measure::named(measure).and_then(NumberKind::of_measure) {
            for key in keys {
                self.key(table, name, key, kind);
            }
        }
    }
}

/// The numbers of a case file that are in doubt, in their order, with the names and places of them.
fn doubts(finder: &mut Finder, known: &mut Known) -> Vec<(String, Range<usize>, String, Doubt)> {
    finder.found.sort_by_key(|found| found.span.start);
    let value = |found: &Found| parse_quantity(&found.text, found.kind.dimension()).ok();
    for found in finder.found.iter().filter(|found| found.kind == NumberKind::Stress && !is_bare(&found.text))
    {
        known.add(value(found).unwrap_or(0.0));
    }
    // Of the column of a history the largest stress decides: a path may begin at zero.
    let mut largest: Vec<f64> = vec![0.0; finder.columns];
    let bare = || finder.found.iter().filter(|found| is_bare(&found.text));
    for (found, column) in bare().filter_map(|found| Some((found, found.column?))) {
        largest[column] = largest[column].max(value(found).unwrap_or(0.0).abs());
    }
    let mut all = Vec::new();
    for found in bare() {
        let Some(value) = value(found) else { continue };
        if found.kind == NumberKind::Stress
            && found.column.is_some_and(|column| known.is_near(largest[column]))
        {
            known.add(largest[found.column.unwrap_or(0)]);
            continue;
        }
        if let Some(doubt) = known.doubt(found.kind, value, &found.text) {
            all.push((found.name.clone(), found.span.clone(), found.text.clone(), doubt));
        }
    }
    all
}

/// A mistake in a case file: its place, what is wrong and what would be right.
pub(super) type Mistake = (Range<usize>, String, String);

/// The mistakes in the text of a case file, which was read as this case; `file` finds the histories that it names.
///
/// # Errors
/// As for [`history_in_doubt`].
pub(super) fn check(
    document: &DeTable<'_>,
    case: &Case,
    file: impl Fn(&str) -> Option<std::path::PathBuf>,
) -> Result<Vec<Mistake>> {
    let mut finder = Finder::new(case.vocabulary.paths());
    finder.document(document);
    let mut known = Known::of_sample(case.preparation.mean_stress);
    let all = doubts(&mut finder, &mut known);
    for path in finder.files.iter().filter_map(|(name, _)| file(name)) {
        history_in_doubt(&path, &mut known)?;
    }
    // A column of a history that is in doubt has as many mistakes as rows.
    let mut last = String::new();
    let once = |(name, ..): &(String, Range<usize>, String, Doubt)| {
        let new = *name != last || !name.contains(".rows ");
        last = name.clone();
        new
    };
    let mistake = |(name, span, text, doubt): (String, Range<usize>, String, Doubt)| {
        (span, format!("{name} = {text} {}", doubt.message()), doubt.help())
    };
    Ok(all.into_iter().filter(once).map(mistake).collect())
}

/// Refuses a history whose header gives no unit for a column that is in doubt.
///
/// # Errors
/// [`Error::Input`] at the name of the column; as for [`history::read`].
fn history_in_doubt(path: &Path, known: &mut Known) -> Result<()> {
    history::check_bare(path, |quantity, largest| {
        known.doubt(NumberKind::of_quantity(quantity), largest, &format_number(largest))
    })
}

/// The text of a resolved case with units where its numbers would be in doubt.
pub(super) fn with_units(text: String, case: &Case) -> String {
    let Ok(document) = DeTable::parse(&text) else { return text };
    let mut finder = Finder::new(case.vocabulary.paths());
    finder.document(document.get_ref());
    let all = doubts(&mut finder, &mut Known::of_sample(case.preparation.mean_stress));
    drop(document);
    let mut text = text;
    for (_, span, _, doubt) in all.into_iter().rev() {
        text.replace_range(span, &format!("\"{}\"", doubt.exact()));
    }
    text
}

/// A key of a case with its text, as a flag gives them.
#[derive(Clone, Copy, Debug)]
pub struct SetKey<'a> {
    /// The flag, for messages, e.g. `--set stage.1.lateral_stress`.
    pub flag: &'a str,
    /// The key, e.g. `stage.1.lateral_stress`.
    pub path: &'a str,
    /// Its value.
    pub text: &'a str,
}

impl Case {
    /// Refuses stresses and strains without a unit, given by flags that were already applied to this case, if they are far from those
    /// of the sample and of the case `before` the flags.
    ///
    /// # Errors
    /// [`Error::Value`] for the first of them, with what was understood and what was probably meant.
    pub fn check_bare_numbers(&self, before: &Case, keys: &[SetKey]) -> Result<()> {
        let mut known = Known::of_sample(self.preparation.mean_stress);
        let text = before.resolved_toml();
        if let Ok(document) = DeTable::parse(&text) {
            let mut finder = Finder::new(self.vocabulary.paths());
            finder.document(document.get_ref());
            for found in finder.found.iter().filter(|found| found.kind == NumberKind::Stress) {
                known.add(parse_quantity(&found.text, Dimension::STRESS).unwrap_or(0.0));
            }
        }
        let kind = |key: &SetKey| self.kind_of(key.path);
        let numbers: Vec<(&SetKey, NumberKind, &str)> = keys
            .iter()
            .filter_map(|key| Some((key, kind(key)?)))
            .flat_map(|(key, kind)| key.text.split(',').map(move |text| (key, kind, text.trim())))
            .collect();
        for (_, kind, text) in
            numbers.iter().filter(|(_, kind, text)| *kind == NumberKind::Stress && !is_bare(text))
        {
            known.add(parse_quantity(text, kind.dimension()).unwrap_or(0.0));
        }
        for (key, kind, text) in numbers.into_iter().filter(|(_, _, text)| is_bare(text)) {
            let Ok(value) = parse_quantity(text, kind.dimension()) else { continue };
            if let Some(doubt) = known.doubt(kind, value, text) {
                let message = format!("{}; {}", doubt.message(), doubt.help());
                return Err(Error::Value { name: key.flag.into(), value: key.text.into(), message });
            }
        }
        for key in keys.iter().filter(|key| self.is_history(key.path)) {
            history_in_doubt(Path::new(key.text), &mut known)?;
        }
        Ok(())
    }

    /// The kind of a key.
    fn kind_of(&self, path: &str) -> Option<NumberKind> {
        match self.parameter_of(path) {
            Some(parameter) => NumberKind::of_parameter(parameter),
            None => NumberKind::of_field(path),
        }
    }

    fn is_history(&self, path: &str) -> bool {
        self.parameter_of(path).is_some_and(|parameter| parameter.kind == PathParameterKind::History)
    }
}
