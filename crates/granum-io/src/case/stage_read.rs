//! Reading the tables `[[stage]]` and `[[preparation.stage]]` of a case file.

use std::ops::Range;

use granum_dem::loading::preset::{Given, PathParameterKind, PathValue, Preset};
use granum_dem::loading::{Control, Drive, Kinematics, SERVO_LIMIT, Speed, Stage, Start, Until};
use granum_dem::servo::COMPONENTS;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::case_stage::{CaseStage, MOST_STAGES};
use super::history::{self, HISTORY_KEYS};
use super::incremental_driver::{self, Options};
use super::reader::Reader;
use super::stage::{
    NOTHING_RECORDED, NOTHING_SAVED, PREPARATION_STAGE, RECORDING_KEYS, STAGE, fault_of_order, goes_back,
    parse_value, path_fault, too_many, too_nested, without_recording,
};
use super::stage_values::{
    Mistake, Node, Parsed, boolean, constraint, drive, end, numbers, record, scalar, text, turns,
};
use super::stage_values::{number, whole};
use super::suggestion::{meant, paths_with};
use granum_core::quantity::Dimension;

/// Keys of a stage with an explicit control, with their meaning.
pub(super) const STAGE_KEYS: &[[&str; 2]] = &[
    ["name", "A name, for the reader."],
    [
        "inertial_number",
        "Speed: the strain rate that counts as 1, as an inertial number at the mean stress at the start of the stage.",
    ],
    ["strain_rate", "Speed, instead of inertial_number: the strain rate that counts as 1."],
    [
        "xx",
        "Control of this component: \"fixed\", \"free\", { rate = ... }, { stress = ... }, { stress_rate = ... }, or a \
         ramp { strain_to = ... }, { strain_by = ... }, { stress_to = ... }, { stress_by = ... }.",
    ],
    ["yy", "As xx."],
    ["zz", "As xx."],
    ["yz", "As xx; shear strains are angles."],
    ["zx", "As xx."],
    ["xy", "As xx."],
    ["constraint", "Combinations of stresses or of strain rates that are controlled, as a list of tables."],
    ["kinematics", "How shear rates move the cell: \"pure-shear\" or \"simple-shear\"."],
    [
        "servo_limit",
        "Bound on the strain rate that the servo adds for one controlled stress, as a multiple of the rate that counts \
         as 1.",
    ],
    ["servo_response", "Time constant of the servo, in time steps."],
    ["turns", "Turning points of a cyclic stage: { measure = ..., high = ..., low = ... }."],
    [
        "until",
        "End conditions, the first of which to be met ends the stage: measures with values, reversals, ramp_over, \
         pore_pressure_ratio, double_amplitude, unbalanced_force, critical_state.",
    ],
    ["most_arc_length", "Arc length of strain after which the stage ends in any case."],
    [
        "record",
        "The states that are recorded: { measure = ..., every = ... }, { ..., states = ..., end = ... } or { ..., at = \
         [...] }.",
    ],
    ["settling", "True if velocities are damped globally, so that the sample comes to rest."],
    ["resets", "True if strain, time and energy count from the start of this stage."],
    [
        "density_scaling",
        "Factor on the density of every grain in this stage; only together with strain_rate.",
    ],
    [
        "start",
        "Initial state. \"here\": where the stage before ended; \"kept\": the same, and later stages can go back to \
         it; \"back\": the state that was kept last.",
    ],
];

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
struct TableReader<'r, 'a> {
    reader: &'r mut Reader<'a>,
    name: String,
}

impl TableReader<'_, '_> {
    fn take<T>(&mut self, key: &str, found: Parsed<T>) -> Option<T> {
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
    fn records_nothing(&mut self, table: &DeTable<'_>, keys: &[&str]) {
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

    fn unknown<'n>(&mut self, key: &str, span: Range<usize>, names: impl Iterator<Item = &'n str> + Clone) {
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
            table.iter().filter(|(key, _)| !["path", "resets"].contains(&key.get_ref().as_ref()))
        {
            let name = key.get_ref();
            if of_history.is_some() && HISTORY_KEYS.contains(&name.as_ref()) {
                continue;
            }
            let Some(parameter) = preset.parameter(name) else {
                let known = preset.parameters().map(|known| known.key).chain(["resets"]);
                self.unknown(name, key.span(), known);
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
        if self.reader.errors.len() == before
            && let Some((key, message)) = path_fault(preset, &parameters)
        {
            let at = table.get_key_value(key).map_or(span.clone(), |(key, _)| key.span());
            self.reader.error(at, format!("{}.{message}", self.name));
        }
        Some(CaseStage::Path { path: preset, parameters, resets })
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

    /// A stage with an explicit control.
    fn written_out(mut self, table: &DeTable<'_>) -> Option<CaseStage> {
        for (key, _) in table {
            if !STAGE_KEYS.iter().any(|[known, _]| *known == key.get_ref()) {
                let names = STAGE_KEYS.iter().map(|[known, _]| *known).chain(["path"]);
                self.unknown(key.get_ref(), key.span(), names);
                let paths = paths_with(self.reader.reading.vocabulary.paths(), key.get_ref());
                if let (Some(paths), Some(error)) = (paths, self.reader.errors.last_mut()) {
                    error.help = Some(format!("{} belongs to a stage with path = {paths}", key.get_ref()));
                }
            }
        }
        self.records_nothing(table, &["record"]);
        let mut control = self.control(table);
        let mut until = Vec::new();
        match table.get("until").map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Table(ends))) => {
                let mut ends: Vec<_> = ends.iter().collect();
                ends.sort_by_key(|(key, _)| key.span().start);
                for (key, value) in ends {
                    let found = end(key.get_ref(), value);
                    until.extend(self.take(&format!("until.{}", key.get_ref()), found));
                }
            }
            Some((value, _)) => {
                let example = "e.g. until = { xx_strain = 0.1 }".to_string();
                self.take::<()>("until", Err(Mistake(value.span(), "is not a table".into(), Some(example))));
            }
            None if control.has_ramp() => until.push(Until::RampOver),
            None => {
                let span = table.values().next().map_or(0..0, Spanned::span);
                let message = format!("{} has no until, so that it would not end", self.name);
                self.reader.error(span, message).help =
                    Some("add one, e.g. until = { xx_strain = 0.1, arc_length = 0.5 }".into());
            }
        }
        let moving = control.is_strained() || control.moves_a_stress();
        control.servo_limit = self
            .key(table, "servo_limit", |value| number(value, Dimension::NUMBER, [1e-3, 1e6]))
            .unwrap_or(if moving { SERVO_LIMIT } else { 1.0 });
        let response =
            self.key(table, "servo_response", |value| number(value, Dimension::NUMBER, [2.0, 1e4]));
        control.response = response.unwrap_or(control.response);
        let name = self.key(table, "name", text).unwrap_or_else(|| "stage".into());
        let mut stage = Stage::new(name, control, until);
        let most = self.key(table, "most_arc_length", |value| number(value, Dimension::NUMBER, [1e-9, 1e6]));
        stage.most_arc_length = most.or(stage.most_arc_length);
        stage.turns = self.key(table, "turns", turns);
        stage.record = self.key(table, "record", record).unwrap_or(stage.record);
        stage.settling = self.key(table, "settling", boolean).unwrap_or(false);
        stage.resets = self.key(table, "resets", boolean).unwrap_or(false);
        let scaling =
            self.key(table, "density_scaling", |value| number(value, Dimension::NUMBER, [1e-6, 1e24]));
        if let (Some(_), Speed::InertialNumber { .. }, Some(value)) =
            (scaling, stage.control.speed, table.get("density_scaling"))
        {
            let why = "has no effect without strain_rate".to_string();
            let help = Some("add strain_rate, or give inertial_number alone".to_string());
            self.take::<()>("density_scaling", Err(Mistake(value.span(), why, help)));
        }
        stage.density_scaling = scaling.unwrap_or(1.0);
        stage.start = self.key(table, "start", start).unwrap_or_default();
        Some(CaseStage::Control(Box::new(stage)))
    }

    /// Reads a key if it is given.
    fn key<T>(&mut self, table: &DeTable<'_>, key: &str, read: impl Fn(&Node<'_>) -> Parsed<T>) -> Option<T> {
        let value = table.get(key)?;
        self.take(key, read(value))
    }

    fn control(&mut self, table: &DeTable<'_>) -> Control {
        let mut control = Control::default();
        let inertial = self.key(table, "inertial_number", |v| number(v, Dimension::NUMBER, [1e-8, 0.1]));
        let rate = self.key(table, "strain_rate", |v| number(v, Dimension::RATE, [1e-12, 1e9]));
        if let (Some(_), Some(_), Some(value)) = (inertial, rate, table.get("strain_rate")) {
            let help = Some("keep one of them".to_string());
            let why = "sets the speed, and so does inertial_number".to_string();
            self.take::<()>("strain_rate", Err(Mistake(value.span(), why, help)));
        }
        if let Some(number) = inertial {
            control.speed = Speed::InertialNumber { number, at: None };
        }
        if let Some(rate) = rate {
            control.speed = Speed::StrainRate(rate);
        }
        let mut absolute = false;
        for (k, name) in COMPONENTS.iter().enumerate() {
            let Some((drive, in_rates)) = self.key(table, name, drive) else { continue };
            if in_rates && (inertial.is_some() || rate.is_some() || control.is_strained() && !absolute) {
                let help = Some("give it as a multiple of that, a number without unit".to_string());
                let why =
                    "is an absolute strain rate, but the speed of the stage is already given".to_string();
                let span = table.get(*name).map_or(0..0, Spanned::span);
                self.take::<()>(name, Err(Mistake(span, why, help)));
                continue;
            }
            absolute |= in_rates;
            control.components[k] = drive;
        }
        if absolute {
            in_multiples(&mut control);
        }
        if let Some(DeValue::Array(items)) = table.get("constraint").map(Spanned::get_ref) {
            for (k, item) in items.iter().enumerate() {
                let found = if k < 6 {
                    constraint(item)
                } else {
                    Err(Mistake(item.span(), "is one too many; there are six strain rates".into(), None))
                };
                control.constraints[k.min(5)] = self.take(&format!("constraint.{}", k + 1), found);
            }
        } else if let Some(value) = table.get("constraint") {
            let help = Some("e.g. constraint = [{ stress = [1, 1, 1, 0, 0, 0] }]".to_string());
            self.take::<()>("constraint", Err(Mistake(value.span(), "is not a list of tables".into(), help)));
        }
        let kinematics = self.key(table, "kinematics", |value| match text(value)?.as_str() {
            "pure-shear" => Ok(Kinematics::PureShear),
            "simple-shear" => Ok(Kinematics::SimpleShear),
            _ => {
                let why = "is not known; it must be \"pure-shear\" or \"simple-shear\"";
                Err(Mistake(value.span(), why.into(), None))
            }
        });
        Control { kinematics: kinematics.unwrap_or_default(), ..control }
    }
}

/// Converts strain rates with a unit to multiples of the largest of them.
fn in_multiples(control: &mut Control) {
    let rates = control.components.iter().filter_map(|drive| match drive {
        Drive::Rate(rate) => Some(rate.abs()),
        _ => None,
    });
    let largest = rates.fold(0.0, f64::max);
    if largest > 0.0 {
        control.speed = Speed::StrainRate(largest);
        for drive in &mut control.components {
            if let Drive::Rate(rate) = drive {
                *rate /= largest;
            }
        }
    }
}

fn start(value: &Node<'_>) -> Parsed<Start> {
    match text(value)?.as_str() {
        "here" => Ok(Start::Here),
        "kept" => Ok(Start::Kept),
        "back" => Ok(Start::Back),
        _ => {
            let why = "is not known; it must be \"here\", \"kept\" or \"back\"";
            Err(Mistake(value.span(), why.into(), None))
        }
    }
}
