//! Reading a case file: all mistakes are reported at once, each with its position and what would be right.

use std::collections::{BTreeMap, HashMap};
use std::ffi::OsStr;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use granum_dem::contact::choice::check;
use granum_dem::contact::choice::law_error::LawError;
use granum_dem::shape::ShapeEntry;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::bare_number;
use super::bond::BOND;
use super::case_stage::{PREPARATION_STAGE, STAGE};
use super::case_test::{CaseTest, is_of_shear};
use super::definition::Case;
use super::field::{Field, Value};
use super::fields::{Fields, RENAMED, SECTIONS};
use super::reader::{ListError, Reader, scalar};
use super::reading::Reading;
use super::rules::RULES;
use super::sensor_parameters;
use super::shape::FILE;
use super::shape_value::SHAPE;
use super::sieve;
use super::suggestion;
use crate::error::{Error, InputError, Result};
use crate::run::{CASE, RECORD};
use crate::shell::ShowPath;

/// A case file is a page or two long, but for histories of many rows in the case of a run; a larger file is something else.
pub(super) const LARGEST_FILE: u64 = 1 << 23;

impl Case {
    /// Reads a case file.
    ///
    /// # Errors
    /// If the file cannot be read, or as for [`Case::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Case> {
        Case::read_as(path, Reading::default())
    }

    /// The same, with a choice of what is taken without question. The file of a run's folder is its record, in which numbers need no
    /// units.
    ///
    /// # Errors
    /// As for [`Case::read`].
    pub fn read_as(path: impl AsRef<Path>, reading: Reading) -> Result<Case> {
        Ok(Case::read_with_shapes(path, reading)?.0)
    }

    /// The same, with the shapes of its grains as the file has them. A case holds the spheres of a mesh or an image in place of its name.
    ///
    /// # Errors
    /// As for [`Case::read`].
    pub fn read_with_shapes(path: impl AsRef<Path>, reading: Reading) -> Result<(Case, Vec<ShapeEntry>)> {
        let path = path.as_ref();
        let text = crate::text::read_small(path, LARGEST_FILE)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let recorded = path.file_name() == Some(OsStr::new(CASE)) && folder.join(RECORD).is_file();
        let reading = match recorded {
            true => {
                let Reading { outside, vocabulary, law_only, .. } = reading;
                Reading { outside, vocabulary, law_only, ..Reading::recorded() }
            }
            false => reading,
        };
        Case::parse_in(&text, &path.shown(), folder, reading)
    }

    /// Reads the text of a case file; `file` is its name for messages.
    ///
    /// # Errors
    /// [`Error::Inputs`] with all mistakes: syntax, unknown keys (with the nearest existing one), wrong dimension, values
    /// out of bounds, keys that exclude each other, stresses and strains that need their units.
    pub fn parse(text: &str, file: &str) -> Result<Case> {
        Case::parse_as(text, file, Reading::default())
    }

    /// The same, with a choice of what is taken without question.
    ///
    /// # Errors
    /// As for [`Case::parse`].
    pub fn parse_as(text: &str, file: &str, reading: Reading) -> Result<Case> {
        Ok(Case::parse_in(text, file, Path::new(file).parent().unwrap_or(Path::new("")), reading)?.0)
    }

    /// Reads the text of a case file in a folder, in which the files lie that it names.
    fn parse_in(text: &str, file: &str, folder: &Path, reading: Reading) -> Result<(Case, Vec<ShapeEntry>)> {
        let text: Arc<str> = Arc::from(text);
        let document = DeTable::parse(&text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let message = format!("this is not TOML: {}", error.message().replace('\n', "; "));
            Error::Inputs(vec![InputError::in_text(file, &text, span, message)])
        })?;
        let bare_numbers = reading.bare_numbers;
        let vocabulary = reading.vocabulary.clone();
        let fields = Fields::new(&vocabulary);
        let mut reader = Reader {
            file,
            folder,
            reading,
            fields: fields.clone(),
            text: text.clone(),
            errors: Vec::new(),
            keys: HashMap::new(),
            values: HashMap::new(),
            stages: Vec::new(),
            preparation_stages: Vec::new(),
            materials: Vec::new(),
            pairs: Vec::new(),
            bonds: Vec::new(),
            shapes: Vec::new(),
            file_of_shape: None,
            written_shapes: Vec::new(),
            undeclared_parameters: BTreeMap::new(),
        };
        reader.table(document.get_ref(), "");
        reader.check_rate();
        reader.check_density();
        reader.check_spacing();
        reader.check_stages();
        let stages = std::mem::take(&mut reader.stages);
        let mut case = Case {
            test: if stages.is_empty() { CaseTest::default() } else { CaseTest::Stages(stages) },
            preparation_stages: std::mem::take(&mut reader.preparation_stages),
            bonds: std::mem::take(&mut reader.bonds),
            vocabulary,
            ..Case::default()
        };
        for field in fields.iter() {
            if let Some(value) = reader.values.get(&field.path()) {
                field.apply(&mut case, value.clone());
            }
        }
        case.recording.parameters.append(&mut reader.undeclared_parameters);
        let (materials, pairs) = (std::mem::take(&mut reader.materials), std::mem::take(&mut reader.pairs));
        if !(materials.is_empty() && pairs.is_empty()) {
            case.grains.mixture = reader.mixture(&case, materials, pairs);
        }
        let shapes = std::mem::take(&mut reader.shapes);
        reader.finish_shapes(&mut case, shapes);
        if reader.errors.is_empty() {
            reader.check_rules(&case);
        }
        if reader.errors.is_empty() && !bare_numbers {
            reader.check_bare_numbers(document.get_ref(), &case);
        }
        reader.errors.sort_by_key(|error| error.span.start);
        if reader.errors.is_empty() {
            Ok((case, reader.written_shapes))
        } else {
            Err(Error::Inputs(reader.errors))
        }
    }

    /// Sets one field from text, as given by a flag of the program: `case.set("grains.diameter", "0.2 mm")`.
    ///
    /// # Errors
    /// [`Error::Value`] if there is no such field, or the text is not a value for it. The case is then unchanged.
    pub fn set(&mut self, path: &str, text: &str) -> Result<()> {
        let wrong =
            |message: String| Error::Value { name: path.to_string(), value: text.to_string(), message };
        if path.starts_with("stage.") || path.starts_with("preparation.stage.") {
            return self.set_stage(path, text);
        }
        if path.split('.').next() == Some(BOND) {
            return self.set_bond(path, text);
        }
        if path.starts_with("material.") || path.starts_with("pair.") {
            return self.set_material(path, text);
        }
        if path.strip_prefix(SHAPE).is_some_and(|rest| rest.matches('.').count() > 1)
            || self.has_shape_tables() && path.starts_with(SHAPE)
        {
            return self.set_shape(path, text);
        }
        if !self.test.uses(path) {
            return Err(wrong("has no effect in a case with stages; set stage.1.KEY instead".into()));
        }
        let field = self.fields().named(path).ok_or_else(|| match new_name(path) {
            Some(new) => wrong(format!("is now called {new}")),
            None => wrong(format!("is not a key; {}", suggestion::of_set(self, path))),
        })?;
        let value = field.parse(text).map_err(wrong)?;
        if path == "shear.density_scaling" && field.value(self).is_none() {
            return Err(wrong("needs shear.strain_rate".into()));
        }
        field.apply(self, value);
        Ok(())
    }
}

impl Reader<'_> {
    fn table(&mut self, table: &DeTable<'_>, section: &str) {
        for (key, value) in table {
            let path = if section.is_empty() {
                key.get_ref().to_string()
            } else {
                format!("{section}.{}", key.get_ref())
            };
            if path == SHAPE && matches!(value.get_ref(), DeValue::Array(_)) {
                self.keys.insert(path, key.span());
                self.shapes = self.shape_tables(value);
            } else if section == SHAPE && key.get_ref() == FILE[0] {
                self.keys.insert(path, key.span());
                self.shape_file(value);
            } else if SECTIONS.iter().any(|[name, _]| *name == path) {
                match value.get_ref() {
                    DeValue::Table(inner) => self.table(inner, &path),
                    _ => {
                        let message = format!("{path} = {} is not a section", self.shown(&value.span()));
                        self.error(value.span(), message).help =
                            Some(format!("write [{path}] with its keys below"));
                    }
                }
            } else if path == STAGE {
                self.keys.insert(path, key.span());
                self.stages = self.stages(value, STAGE);
            } else if path == PREPARATION_STAGE {
                self.keys.insert(path, key.span());
                self.preparation_stages = self.stages(value, PREPARATION_STAGE);
            } else if path == BOND {
                self.keys.insert(path, key.span());
                self.bonds = self.bonds(value);
            } else if path == "material" {
                self.keys.insert(path, key.span());
                self.materials = self.materials(value);
            } else if path == "pair" {
                self.keys.insert(path, key.span());
                self.pairs = self.pairs(value);
            } else if let Some(field) = self.fields.named(&path) {
                self.field(&field, key.span(), value);
            } else if let Some(number) = self.undeclared(section, value.get_ref()) {
                self.undeclared_parameters.insert(key.get_ref().to_string(), number);
            } else if let Some(new) = new_name(&path) {
                let name = new.rsplit('.').next().unwrap_or(new);
                self.error(key.span(), format!("{path} is now called {new}")).help =
                    Some(format!("write {name}"));
            } else {
                let what = if section.is_empty() { "section" } else { "key" };
                let help = suggestion::in_file(&self.fields, self.reading.vocabulary.paths(), &path, section);
                self.error(key.span(), format!("unknown {what} {path}")).help = Some(help);
            }
        }
    }

    /// The value of a parameter of a sensor that this program does not know, where such are taken.
    fn undeclared(&self, section: &str, value: &DeValue<'_>) -> Option<f64> {
        let taken = self.reading.undeclared_parameters && section == "recording";
        taken.then(|| sensor_parameters::undeclared(value)).flatten()
    }

    fn field(&mut self, field: &Field, key: Range<usize>, value: &Spanned<DeValue<'_>>) {
        self.keys.insert(field.path(), key);
        let parsed = match value.get_ref() {
            DeValue::Array(items) if field.is_curve() => Self::points(field, items),
            DeValue::Array(items) if field.is_spheres() => Self::spheres(items),
            DeValue::String(name)
                if field.is_curve() && field.words().iter().all(|[word, _]| word != name) =>
            {
                let file = self.named_file(name).map_err(|why| (None, why));
                file.and_then(|file| match sieve::read(&file) {
                    Ok(points) => Ok(Value::Curve(points)),
                    Err(error) => Err((None, format!("cannot be used: {error}"))),
                })
            }
            DeValue::Array(items) if field.is_list() => Self::list(field, items),
            other => scalar(field, other).and_then(|text| field.parse(&text)).map_err(|why| (None, why)),
        };
        match parsed {
            Ok(value) => {
                self.values.insert(field.path(), value);
            }
            Err((Some((number, span)), why)) => {
                let message = format!("{}: value {number} = {} {why}", field.path(), self.shown(&span));
                self.error(span, message);
            }
            Err((None, why)) => {
                let message = format!("{} = {} {why}", field.path(), self.shown(&value.span()));
                let quoted = field.example.parse::<f64>().is_err();
                let example = if quoted { format!("{:?}", field.example) } else { field.example.clone() };
                self.error(value.span(), message).help = Some(format!("e.g. {} = {example}", field.key));
            }
        }
    }

    /// The values of a list; an error gives the number of the wrong value, from 1, and its position in the file.
    fn list(field: &Field, items: &[Spanned<DeValue<'_>>]) -> std::result::Result<Value, ListError> {
        let mut texts = Vec::with_capacity(items.len());
        for (at, item) in items.iter().enumerate() {
            let text = scalar(field, item.get_ref()).map_err(|why| (Some((at + 1, item.span())), why))?;
            texts.push(text);
        }
        field
            .parse_list(texts.iter().map(String::as_str))
            .map_err(|(at, why)| (at.and_then(|at| Some((at + 1, items.get(at)?.span()))), why))
    }

    /// The points of a sieve curve.
    fn points(field: &Field, items: &[Spanned<DeValue<'_>>]) -> std::result::Result<Value, ListError> {
        let point = |item: &Spanned<DeValue<'_>>| {
            let DeValue::Array(cells) = item.get_ref() else {
                return Err(format!("must be {}", field.bounds_text()));
            };
            let cells: Vec<String> = cells
                .iter()
                .map(|cell| scalar(field, cell.get_ref()))
                .collect::<std::result::Result<_, _>>()?;
            sieve::point(&cells.iter().map(String::as_str).collect::<Vec<_>>())
        };
        let numbered = |(at, item): (usize, &Spanned<DeValue<'_>>)| {
            point(item).map_err(|why| (Some((at + 1, item.span())), why))
        };
        let points = items.iter().enumerate().map(numbered).collect::<std::result::Result<Vec<_>, _>>()?;
        sieve::check(points).map(Value::Curve).map_err(|why| (None, why))
    }

    /// Checks that the strains of the states are given in one way only.
    fn check_spacing(&mut self) {
        let first = self.values.get("recording.first_strain");
        let strains = self.values.get("recording.strains");
        if let (Some(Value::Number(Some(_))), Some(Value::List(list))) = (first, strains)
            && !list.is_empty()
            && let Some(span) = self.keys.get("recording.strains").cloned()
        {
            let message = "recording.strains and recording.first_strain both set where states are recorded";
            self.error(span, message.into()).help =
                Some("keep strains, or first_strain with states; the other is \"none\"".into());
        }
    }

    /// Checks that the density of the sample is given in one way only.
    fn check_density(&mut self) {
        let given = |key: &&str| matches!(self.values.get(*key), Some(Value::Number(Some(_))));
        let keys = ["preparation.void_ratio", "preparation.relative_density", "preparation.solid_fraction"];
        let keys: Vec<&str> = keys.into_iter().filter(|key| given(key)).collect();
        if let [first, second, ..] = keys.as_slice()
            && let Some(span) = self.keys.get(*first).cloned()
        {
            let message = format!("{first} and {second} both say how dense the sample is to be");
            self.error(span, message).help = Some("keep one of them".into());
        }
    }

    /// Checks that the test is given in one way only. Keys at their defaults say nothing: a case as `granum init` writes it has them
    /// all, and stages may be added to it.
    fn check_stages(&mut self) {
        if !self.keys.contains_key(STAGE) {
            return;
        }
        let standard = Case::default();
        let says_something = |field: &Field| {
            self.values.get(&field.path()).is_some_and(|value| field.value(&standard).as_ref() != Some(value))
        };
        let unused = self.fields.iter().filter(|field| is_of_shear(&field.path()) && says_something(field));
        let unused: Vec<_> = unused.map(|field| field.path()).collect();
        for path in unused {
            let Some(span) = self.keys.get(&path).cloned() else { continue };
            self.error(span, format!("{path} has no effect in a case with [[stage]]")).help = Some(
                "leave it out: each stage sets its own loading, its end and the states that it records"
                    .into(),
            );
        }
    }

    /// Checks that the rate of the test is given in one way only.
    fn check_rate(&mut self) {
        let place = |reader: &Self, key: &str| reader.keys.get(key).cloned();
        let inertial = place(self, "shear.inertial_number");
        let strain_rate = place(self, "shear.strain_rate");
        let scaling = place(self, "shear.density_scaling");
        if let (Some(_), Some(span)) = (&inertial, &strain_rate) {
            self.error(
                span.clone(),
                "shear.strain_rate and shear.inertial_number both set the speed".into(),
            )
            .help = Some("keep inertial_number, or strain_rate with density_scaling".into());
        } else if let (None, Some(span)) = (strain_rate, scaling) {
            self.error(span, "shear.density_scaling has no effect without shear.strain_rate".into()).help =
                Some("add strain_rate, e.g. strain_rate = \"1e-5 /s\", or give inertial_number alone".into());
        }
    }

    /// Checks that stresses and strains far from those of the sample have units.
    fn check_bare_numbers(&mut self, document: &DeTable<'_>, case: &Case) {
        match bare_number::check(document, case, |name| self.named_file(name).ok()) {
            Ok(mistakes) => {
                for (span, message, help) in mistakes {
                    self.error(span, message).help = Some(help);
                }
            }
            Err(Error::Input(error)) => self.errors.push(*error),
            Err(error) => {
                self.error(0..0, error.to_string());
            }
        }
    }

    fn check_rules(&mut self, case: &Case) {
        if let Err(error) = check::check(&case.contact) {
            let keys = match &error {
                LawError::Unused { key, .. } | LawError::OutOfBounds { key, .. } => vec![*key],
                LawError::Apart { slot, .. } => vec![*slot, "normal"],
            };
            let given = keys.iter().find_map(|key| self.keys.get(&format!("contact.{key}")));
            let span = given.cloned().unwrap_or(0..0);
            self.error(span, error.to_string());
        }
        if let Err(error) = case.grains.check_sizes() {
            let span =
                self.keys.get(&format!("grains.{}", error.key)).or(self.keys.get("grains.distribution"));
            let span = span.cloned().unwrap_or(0..0);
            self.error(span, error.to_string());
            return;
        }
        if let Err(error) = case.grains.check_shapes() {
            let span = self.keys.get(&format!("{SHAPE}.{}", error.key)).or(self.keys.get(SHAPE));
            let span = span.or(self.keys.get("grains.shape.kind")).cloned().unwrap_or(0..0);
            self.error(span, format!("{SHAPE}.{error}"));
            return;
        }
        self.check_bonds(case);
        let law_only = self.reading.law_only;
        for rule in RULES.iter().filter(|rule| !law_only || rule.is_of_law()) {
            let Some(message) = (rule.broken)(case) else { continue };
            let given = rule.fields.iter().find_map(|path| self.keys.get(*path));
            let span = given.cloned().unwrap_or(0..0);
            self.error(span, message);
        }
    }
}

/// The present name of a renamed key.
fn new_name(path: &str) -> Option<&'static str> {
    RENAMED.iter().find(|[old, _]| *old == path).map(|[_, new]| *new)
}
