//! Reading the tables `[[stage]]` and `[[preparation.stage]]` of a case file.

use std::ops::Range;

use granum_dem::loading::preset::{Given, PathParameterKind, PathValue, Preset};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::case_stage::{CaseStage, MOST_STAGES, PREPARATION_STAGE, STAGE, driven};
use super::history::{self, HISTORY_KEYS};
use super::incremental_driver::{self, Options};
use super::reader::Reader;
use super::stage::{
    NOTHING_RECORDED, NOTHING_SAVED, RECORDING_KEYS, fault_of_order, goes_back, parse_value, path_fault,
    too_many, too_nested, without_recording,
};
use super::stage_values::{Mistake, Node, Parsed, boolean, numbers, scalar, text};
use super::stage_values::{number, whole};
use super::suggestion::meant;
use granum_core::quantity::Dimension;

/// Keys of stages that a file of the IncrementalDriver gives, with their meaning.
pub(super) const DRIVER_KEYS: &[[&str; 2]] = &[
    [
        "incremental_driver",
        "A loading path (test.inp) of Niemunis' IncrementalDriver, whose steps become stages.",
    ],
    ["stress_unit", "The unit of stress of that file, e.g. \"1 kPa\"."],
    ["inertial_number", "Speed of its stages: inertial number of the largest strain rate."],
    ["interval", "Arc length of strain between recorded states."],
];

/// Keys of a stage that repeats others.
pub(super) const REPEAT_KEYS: [&str; 2] = ["repeat", "stage"];

impl Reader<'_> {
    /// Reads the tables below a heading, [`STAGE`] or [`PREPARATION_STAGE`]; mistakes are added to those of the reader.
    pub(super) fn stages(&mut self, value: &Node<'_>, heading: &str) -> Vec<CaseStage> {
        let before = self.errors.len();
        let (stages, spans): (Vec<_>, Vec<_>) = self.list_of_stages(value, heading).into_iter().unzip();
        if self.errors.len() > before {
            return stages;
        }
        let nested = stages.iter().zip(&spans).find_map(|(stage, span)| Some((too_nested(stage)?, span)));
        if let Some((message, span)) = nested {
            self.error(span.clone(), format!("this {heading} {message}"));
        } else if let Some(message) = too_many(&stages) {
            self.error(value.span(), message);
        } else if let Some((number, message)) = fault_of_order(&stages) {
            self.error(spans.get(number - 1).cloned().unwrap_or(0..0), format!("stage.{number} {message}"));
        }
        stages
    }

    fn list_of_stages(&mut self, value: &Node<'_>, name: &str) -> Vec<(CaseStage, Range<usize>)> {
        let DeValue::Array(tables) = value.get_ref() else {
            let message = format!("{name} = {} is not a list of tables", self.shown(&value.span()));
            self.error(value.span(), message).help =
                Some(format!("write [[{}]] with its keys below", heading(name)));
            return Vec::new();
        };
        let mut stages = Vec::new();
        for (k, table) in tables.iter().enumerate() {
            let name = format!("{name}.{}", k + 1);
            let found = match table.get_ref() {
                DeValue::Table(inner) if inner.contains_key("incremental_driver") => {
                    let place = TableReader { reader: self, name };
                    let found = place.incremental_driver(inner, &table.span());
                    stages.extend(found.into_iter().map(|stage| (stage, table.span())));
                    continue;
                }
                DeValue::Table(inner) => self.stage(inner, name, table.span()),
                other => {
                    let message = format!("{name} is of type {}; it must be a table", other.type_str());
                    self.error(table.span(), message);
                    None
                }
            };
            stages.extend(found.map(|stage| (stage, table.span())));
        }
        stages
    }

    fn stage(&mut self, table: &DeTable<'_>, name: String, span: Range<usize>) -> Option<CaseStage> {
        let before = self.errors.len();
        let place = TableReader { reader: self, name: name.clone() };
        let stage = match (table.get("path"), REPEAT_KEYS.iter().any(|key| table.contains_key(*key))) {
            (Some(path), _) => place.named(table, path, &span),
            (None, true) => return place.repeated(table, &span),
            (None, false) => place.written_out(table),
        }?;
        if self.errors.len() == before && is_of_preparation(&name) && goes_back(&stage) {
            self.error(span, format!("{name} {NOTHING_SAVED}")).help =
                Some("leave start out, or choose another path; a [[stage]] of the test can do this".into());
            return Some(stage);
        }
        if self.errors.len() == before
            && let Some(error) = stage.stages().iter().find_map(|stage| stage.control.check().err())
        {
            self.error(span, format!("{name}: {error}"));
        }
        Some(stage)
    }
}

/// True if this is the name of a stage of the preparation.
fn is_of_preparation(name: &str) -> bool {
    name.starts_with(PREPARATION_STAGE)
}

/// The heading of the tables that a list of stages of this name has: `stage.stage` for `stage.2`.
fn heading(name: &str) -> String {
    let is_number = |part: &&str| part.parse::<usize>().is_ok();
    let parts = name.split('.').map(|part| if is_number(&part) { STAGE } else { part });
    parts.collect::<Vec<_>>().join(".")
}

/// A table that is being read, with its name for messages.
pub(super) struct TableReader<'r, 'a> {
    pub(super) reader: &'r mut Reader<'a>,
    pub(super) name: String,
}

impl TableReader<'_, '_> {
    pub(super) fn take<T>(&mut self, key: &str, found: Parsed<T>) -> Option<T> {
        match found {
            Ok(value) => Some(value),
            Err(Mistake(span, why, help)) => {
                let message = format!("{}.{key} = {} {why}", self.name, self.reader.shown(&span));
                self.reader.error(span, message).help = help;
                None
            }
        }
    }

    /// Refuses a key that chooses recorded states if this is a stage of the preparation.
    pub(super) fn records_nothing(&mut self, table: &DeTable<'_>, keys: &[&str]) {
        if !is_of_preparation(&self.name) {
            return;
        }
        for key in keys {
            let Some((found, value)) = table.get_key_value(*key) else { continue };
            let text = self.reader.shown(&value.span());
            let message = format!("{}.{key} = {text} {NOTHING_RECORDED}", self.name);
            self.reader.error(found.span(), message).help = Some("leave it out".into());
        }
    }

    pub(super) fn unknown<'n>(
        &mut self,
        key: &str,
        span: Range<usize>,
        names: impl Iterator<Item = &'n str> + Clone,
    ) {
        let message = format!("unknown key {}.{key}", self.name);
        self.reader.error(span, message).help = Some(meant(key, names));
    }

    /// A stage `path = "..."` with its parameters.
    fn named(mut self, table: &DeTable<'_>, path: &Node<'_>, span: &Range<usize>) -> Option<CaseStage> {
        let paths = self.reader.reading.vocabulary.paths();
        let found = text(path).and_then(|name| {
            paths.named(&name).ok_or_else(|| {
                let help = meant(&name, paths.names());
                Mistake(path.span(), "is not a path".into(), Some(help))
            })
        });
        let preset: &'static Preset = self.take("path", found)?;
        let before = self.reader.errors.len();
        self.records_nothing(table, &RECORDING_KEYS);
        let mut parameters = Given::new();
        let of_history = preset.parameters().find(|parameter| parameter.kind == PathParameterKind::History);
        if let Some(parameter) = of_history
            && let Some(history) = self.history(table, span)
        {
            parameters.insert(parameter.key.to_string(), PathValue::History(history));
        }
        for (key, value) in
            table.iter().filter(|(key, _)| !["path", "resets", "until"].contains(&key.get_ref().as_ref()))
        {
            let name = key.get_ref();
            if of_history.is_some() && HISTORY_KEYS.contains(&name.as_ref()) {
                continue;
            }
            let Some(parameter) = preset.parameter(name) else {
                let keys = preset.parameters().map(|parameter| parameter.key).chain(["resets", "until"]);
                self.unknown(name, key.span(), keys);
                continue;
            };
            let found = match parameter.kind {
                PathParameterKind::List => numbers(value).map(|texts| texts.join(",")),
                _ => scalar(value),
            };
            let found = found.and_then(|text| {
                parse_value(parameter, &text).map_err(|why| Mistake(value.span(), why, None))
            });
            if let Some(value) = self.take(parameter.key, found) {
                parameters.insert(parameter.key.to_string(), value);
            }
        }
        let resets = self.key(table, "resets", boolean).unwrap_or(true);
        let until = self.ends(table);
        if let (Some((key, _)), true) = (table.get_key_value("until"), self.reader.errors.len() == before)
            && driven(&preset.expand(&parameters)).is_none()
        {
            let message =
                format!("{}.until: the path {} has several stages that are driven", self.name, preset.name);
            self.reader.error(key.span(), message).help =
                Some("write the stages out, each as a [[stage]] with its own until".into());
        }
        if self.reader.errors.len() == before
            && let Some((key, message)) = path_fault(preset, &parameters)
        {
            let at = table.get_key_value(key).map_or(span.clone(), |(key, _)| key.span());
            self.reader.error(at, format!("{}.{message}", self.name));
        }
        Some(CaseStage::Path { path: preset, parameters, resets, until })
    }

    /// The history of a path, in a file in the folder of the case or in the table itself; mistakes in the file are reported with
    /// their positions in it.
    fn history(&mut self, table: &DeTable<'_>, span: &Range<usize>) -> Option<granum_dem::loading::History> {
        let file = table.get("file");
        if let (Some(file), Some(_)) = (file, table.get("columns").or(table.get("rows"))) {
            let why = "gives the history, and so do columns and rows".to_string();
            return self.take("file", Err(Mistake(file.span(), why, Some("keep one of them".into()))));
        }
        if let Some(file) = file {
            let name = self.key(table, "file", text)?;
            let path = self.reader.named_file(&name).map_err(|why| Mistake(file.span(), why, None));
            let path = self.take("file", path)?;
            return match history::read(&path) {
                Ok(_)
                    if table.get("compression").is_some()
                        && history::states_signs(&path).unwrap_or(false) =>
                {
                    let why =
                        "states the signs of compression in its comments, and so does the key compression";
                    self.take("file", Err(Mistake(file.span(), why.into(), Some("keep one of them".into()))))
                }
                Ok(history) => Some(history),
                Err(crate::Error::Input(error)) => {
                    self.reader.errors.push(*error);
                    None
                }
                Err(error) => {
                    self.take("file", Err(Mistake(file.span(), format!("cannot be used: {error}"), None)))
                }
            };
        }
        let (Some(columns), Some(rows)) = (table.get("columns"), table.get("rows")) else {
            let message = format!("{} has no history", self.name);
            self.reader.error(span.clone(), message).help = Some("add file = \"NAME.csv\"".into());
            return None;
        };
        let columns = self.take("columns", history::columns(columns))?;
        self.take("rows", history::rows(rows, columns))
    }

    /// The stages of a file of the IncrementalDriver; mistakes in the file are reported with their positions in it.
    fn incremental_driver(mut self, table: &DeTable<'_>, span: &Range<usize>) -> Vec<CaseStage> {
        for (key, _) in table {
            if !DRIVER_KEYS.iter().any(|[known, _]| *known == key.get_ref()) {
                self.unknown(key.get_ref(), key.span(), DRIVER_KEYS.iter().map(|[known, _]| *known));
            }
        }
        self.records_nothing(table, &RECORDING_KEYS);
        let file = self.key(table, "incremental_driver", text);
        let unit = self.key(table, "stress_unit", |value| number(value, Dimension::STRESS, [1e-3, 1e12]));
        let speed = self.key(table, "inertial_number", |value| number(value, Dimension::NUMBER, [1e-8, 0.1]));
        let interval = self.key(table, "interval", |value| number(value, Dimension::NUMBER, [1e-7, 1.0]));
        if !table.contains_key("stress_unit") {
            let message = format!("{} does not give the unit of stress of the file", self.name);
            self.reader.error(span.clone(), message).help =
                Some("add it, e.g. stress_unit = \"1 kPa\"".into());
        }
        let (Some(file), Some(stress_unit)) = (file, unit) else { return Vec::new() };
        let options = Options {
            stress_unit,
            inertial_number: speed.unwrap_or(1e-3),
            interval: interval.unwrap_or(1e-4),
            outside: self.reader.reading.outside,
        };
        let at = table.get("incremental_driver").map_or(span.clone(), Spanned::span);
        let path = self.reader.named_file(&file).map_err(|why| Mistake(at, why, None));
        let Some(path) = self.take("incremental_driver", path) else { return Vec::new() };
        match incremental_driver::read(&path, &options) {
            Ok(stages) if is_of_preparation(&self.name) => {
                if stages.iter().any(goes_back) {
                    let message = format!("{} {NOTHING_SAVED}", self.name);
                    self.reader.error(span.clone(), message);
                }
                stages.into_iter().map(without_recording).collect()
            }
            Ok(stages) => stages,
            Err(crate::Error::Input(error)) => {
                self.reader.errors.push(*error);
                Vec::new()
            }
            Err(error) => {
                let at = table.get("incremental_driver").map_or(span.clone(), Spanned::span);
                let mistake = Mistake(at, format!("cannot be used: {error}"), None);
                self.take::<()>("incremental_driver", Err(mistake));
                Vec::new()
            }
        }
    }

    /// A stage `repeat = N` with the stages that it repeats.
    fn repeated(mut self, table: &DeTable<'_>, span: &Range<usize>) -> Option<CaseStage> {
        for (key, _) in table {
            if !REPEAT_KEYS.contains(&key.get_ref().as_ref()) {
                self.unknown(key.get_ref(), key.span(), REPEAT_KEYS.into_iter());
            }
        }
        let times = self.key(table, "repeat", |value| whole(value, [1.0, MOST_STAGES as f64]));
        let Some(inner) = table.get("stage") else {
            let message = format!("{} has no stages to repeat", self.name);
            self.reader.error(span.clone(), message).help =
                Some(format!("write the stages to repeat below it, as [[{}]]", heading(&self.name)));
            return None;
        };
        let stages = self.reader.list_of_stages(inner, &self.name);
        if stages.is_empty() && matches!(inner.get_ref(), DeValue::Array(_)) {
            self.reader.error(inner.span(), format!("{} has no stages to repeat", self.name));
        }
        let stages = stages.into_iter().map(|(stage, _)| stage).collect();
        // A list of stages within a stage is walked once where it is not said how often.
        Some(CaseStage::Repeat { times: times.unwrap_or(1), stages })
    }

    /// Reads a key if it is given.
    pub(super) fn key<T>(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        read: impl Fn(&Node<'_>) -> Parsed<T>,
    ) -> Option<T> {
        let value = table.get(key)?;
        self.take(key, read(value))
    }
}
