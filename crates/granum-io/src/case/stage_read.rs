//! MacroState the tables `[[stage]]` of a case file.

use std::collections::BTreeMap;
use std::ops::Range;

use granum_dem::config::Spacing;
use granum_dem::loading::preset::{self, Preset};
use granum_dem::loading::{
    Constraint, Control, Drive, Kinematics, Measure, Record, SERVO_LIMIT, Speed, Stage, Target, Turns, Until,
};
use granum_dem::servo::COMPONENTS;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::read::Reader;
use super::stage::{CaseStage, dimension, meant, parse_parameter};
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// A value with its place.
type Node<'a> = Spanned<DeValue<'a>>;

/// Keys of a stage that is written out, with their meaning.
pub(super) const STAGE_KEYS: &[[&str; 2]] = &[
    ["name", "Its name for people."],
    [
        "inertial_number",
        "How fast: inertial number of a strain rate of one, at the mean stress at the start of the stage.",
    ],
    ["strain_rate", "The other way to say how fast: the strain rate of one."],
    [
        "xx",
        "What is done with this component: \"fixed\", \"free\", { rate = ... }, { stress = ... } or { stress_rate = ... }.",
    ],
    ["yy", "As xx."],
    ["zz", "As xx."],
    ["yz", "As xx; shear strains are angles."],
    ["zx", "As xx."],
    ["xy", "As xx."],
    [
        "constraint",
        "Combinations of stresses that are held, or of strain rates that are kept, as a list of tables.",
    ],
    ["kinematics", "How shear rates move the cell: \"pure-shear\" or \"simple-shear\"."],
    [
        "servo_limit",
        "Bound on what the servo adds for one controlled stress, as a multiple of the strain rate of one.",
    ],
    ["servo_response", "Time constant of the servo, in time steps."],
    ["turns", "Turning points of a cyclic stage: { measure = ..., high = ..., low = ... }."],
    [
        "until",
        "Its ends, the first of which ends it: measures with values, reversals, unbalanced_force, critical_state.",
    ],
    ["most_arc_length", "Arc length of strain after which it ends in any case."],
    [
        "record",
        "Which states are recorded: { measure = ..., every = ... }, { ..., states = ..., end = ... } or { ..., at = [...] }.",
    ],
    ["settling", "True if velocities are damped globally, so that the sample comes to rest."],
    ["resets", "True if strain, time and energy count from the start of this stage."],
];

/// Keys that a stage has no default for or may say once more in its `until`.
const CRITICAL: [(&str, f64); 3] = [("window", 0.05), ("stress_ratio", 0.02), ("volumetric_strain", 0.002)];

/// A mistake: its place, what is wrong, and what would be right.
struct Mistake(Range<usize>, String, Option<String>);

type Parsed<T> = Result<T, Mistake>;

impl Reader<'_> {
    /// Reads `[[stage]]`; mistakes go to the others.
    pub(super) fn stages(&mut self, value: &Node<'_>) -> Vec<CaseStage> {
        let DeValue::Array(tables) = value.get_ref() else {
            let message = format!("stage = {} is no list of tables", self.shown(&value.span()));
            self.error(value.span(), message).help = Some("write [[stage]] with its keys below".into());
            return Vec::new();
        };
        let mut stages = Vec::new();
        for (k, table) in tables.iter().enumerate() {
            let found = match table.get_ref() {
                DeValue::Table(inner) => self.stage(inner, k + 1, table.span()),
                other => {
                    let message =
                        format!("stage {} is of type {}; it must be a table", k + 1, other.type_str());
                    self.error(table.span(), message);
                    None
                }
            };
            stages.extend(found);
        }
        stages
    }

    fn stage(&mut self, table: &DeTable<'_>, number: usize, span: Range<usize>) -> Option<CaseStage> {
        let path = table.get("path");
        let before = self.errors.len();
        let place = TableReader { reader: self, name: format!("stage.{number}") };
        let stage = match path {
            Some(path) => place.named(table, path),
            None => place.written_out(table),
        }?;
        let wrong = stage.stages().iter().find_map(|stage| stage.control.check().err());
        if let Some(error) = wrong.filter(|_| self.errors.len() == before) {
            self.error(span, format!("stage.{number}: {error}"));
        }
        Some(stage)
    }
}

/// A table under way, with its name for messages.
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

    fn unknown<'n>(&mut self, key: &str, span: Range<usize>, names: impl Iterator<Item = &'n str> + Clone) {
        let message = format!("unknown key {}.{key}", self.name);
        self.reader.error(span, message).help = Some(meant(key, names));
    }

    /// A stage `path = "..."` with its parameters.
    fn named(mut self, table: &DeTable<'_>, path: &Node<'_>) -> Option<CaseStage> {
        let found = text(path).and_then(|name| {
            preset::named(&name).ok_or_else(|| {
                let help = meant(&name, preset::all().iter().map(|preset| preset.name));
                Mistake(path.span(), "is no path".into(), Some(help))
            })
        });
        let preset: &Preset = self.take("path", found)?;
        let mut parameters = BTreeMap::new();
        for (key, value) in table.iter().filter(|(key, _)| key.get_ref() != "path") {
            let Some(parameter) = preset.parameter(key.get_ref()) else {
                self.unknown(key.get_ref(), key.span(), preset.parameters.iter().map(|known| known.key));
                continue;
            };
            let found = scalar(value).and_then(|text| {
                parse_parameter(parameter, &text).map_err(|why| Mistake(value.span(), why, None))
            });
            if let Some(number) = self.take(parameter.key, found) {
                parameters.insert(parameter.key.to_string(), number);
            }
        }
        Some(CaseStage::Path { name: preset.name.to_string(), parameters })
    }

    /// A stage with its control.
    fn written_out(mut self, table: &DeTable<'_>) -> Option<CaseStage> {
        for (key, _) in table {
            if !STAGE_KEYS.iter().any(|[known, _]| *known == key.get_ref()) {
                let names = STAGE_KEYS.iter().map(|[known, _]| *known).chain(["path"]);
                self.unknown(key.get_ref(), key.span(), names);
            }
        }
        let mut control = self.control(table);
        let mut until = Vec::new();
        match table.get("until").map(|value| (value, value.get_ref())) {
            Some((_, DeValue::Table(ends))) => {
                for (key, value) in ends {
                    let found = end(key.get_ref(), value);
                    until.extend(self.take(&format!("until.{}", key.get_ref()), found));
                }
            }
            Some((value, _)) => {
                let example = "e.g. until = { xx_strain = 0.1 }".to_string();
                self.take::<()>("until", Err(Mistake(value.span(), "is no table".into(), Some(example))));
            }
            None => {
                let span = table.values().next().map_or(0..0, Spanned::span);
                let message = format!("{} has no until, so that nothing would end it", self.name);
                self.reader.error(span, message).help =
                    Some("add one, e.g. until = { xx_strain = 0.1, arc_length = 0.5 }".into());
            }
        }
        let moving = control.is_strained() || moves_a_stress(&control);
        control.servo_limit = self
            .key(table, "servo_limit", |value| number(value, Dimension::NUMBER, [1e-3, 1e6]))
            .unwrap_or(if moving { SERVO_LIMIT } else { 1.0 });
        let response =
            self.key(table, "servo_response", |value| number(value, Dimension::NUMBER, [2.0, 1e4]));
        control.response = response.unwrap_or(control.response);
        let default = Stage::new("", control, Vec::new());
        let name = self.key(table, "name", text).unwrap_or_else(|| "stage".into());
        let most = self.key(table, "most_arc_length", |value| number(value, Dimension::NUMBER, [1e-9, 1e6]));
        let turns = self.key(table, "turns", turns);
        let record = self.key(table, "record", record);
        let settling = self.key(table, "settling", boolean);
        let resets = self.key(table, "resets", boolean);
        Some(CaseStage::Control(Box::new(Stage {
            name,
            turns,
            until,
            most_arc_length: most.or(default.most_arc_length),
            record: record.unwrap_or_else(|| default.record.clone()),
            settling: settling.unwrap_or(false),
            resets: resets.unwrap_or(false),
            ..default
        })))
    }

    /// Reads a key if it is there.
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
            let why = "says how fast, and so does inertial_number".to_string();
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
                let why = "is a strain rate of its own, but the stage says how fast it goes".to_string();
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
            self.take::<()>("constraint", Err(Mistake(value.span(), "is no list of tables".into(), help)));
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

/// Strain rates with a unit become multiples of the largest of them.
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

fn moves_a_stress(control: &Control) -> bool {
    let of_components = control.components.iter().any(|d| matches!(d, Drive::Stress(t) if t.rate != 0.0));
    let strained = |c: &Constraint| c.target.rate != 0.0;
    of_components || control.constraints.iter().flatten().any(strained)
}

/// The text of a number or string.
fn scalar(value: &Node<'_>) -> Parsed<String> {
    match value.get_ref() {
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Float(number) => Ok(number.as_str().replace('_', "")),
        DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str().replace('_', "")),
        other => {
            Err(Mistake(value.span(), format!("is of type {}; it must be a number", other.type_str()), None))
        }
    }
}

fn text(value: &Node<'_>) -> Parsed<String> {
    match value.get_ref() {
        DeValue::String(text) => Ok(text.to_string()),
        other => {
            Err(Mistake(value.span(), format!("is of type {}; it must be text", other.type_str()), None))
        }
    }
}

fn boolean(value: &Node<'_>) -> Parsed<bool> {
    match value.get_ref() {
        DeValue::Boolean(yes) => Ok(*yes),
        other => {
            let why = format!("is of type {}; it must be true or false", other.type_str());
            Err(Mistake(value.span(), why, None))
        }
    }
}

fn number(value: &Node<'_>, dimension: Dimension, [low, high]: [f64; 2]) -> Parsed<f64> {
    let wrong = |why: String| Mistake(value.span(), why, None);
    let number = parse_quantity(&scalar(value)?, dimension).map_err(wrong)? + 0.0;
    if (low..=high).contains(&number) {
        return Ok(number);
    }
    let unit = dimension.si_unit();
    let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
    let (low, high) = (format_number(low), format_number(high));
    Err(wrong(format!("is out of bounds; it must be from {low}{unit} to {high}{unit}")))
}

const ANY_STRESS: [f64; 2] = [-1e12, 1e12];
const ANY_RATE: [f64; 2] = [-1e30, 1e30];

/// The keys of an inner table; other keys are mistakes.
fn inner<'t, 'a>(value: &'t Node<'a>, known: &[&str]) -> Parsed<&'t DeTable<'a>> {
    let DeValue::Table(table) = value.get_ref() else {
        let help = format!("write {{ {} = ... }}", known.first().unwrap_or(&"key"));
        return Err(Mistake(value.span(), "is no table".into(), Some(help)));
    };
    match table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
        None => Ok(table),
        Some(key) => {
            let help = meant(key.get_ref(), known.iter().copied());
            Err(Mistake(key.span(), "is no key of it".into(), Some(help)))
        }
    }
}

/// What is done with a component; true beside it if it is a strain rate with its unit.
fn drive(value: &Node<'_>) -> Parsed<(Drive, bool)> {
    if let DeValue::String(word) = value.get_ref() {
        return match word.as_ref() {
            "fixed" => Ok((Drive::Fixed, false)),
            "free" => Ok((Drive::Free, false)),
            _ => {
                let help =
                    "it must be \"fixed\", \"free\", or a table as { rate = 1 } or { stress = \"100 kPa\" }";
                Err(Mistake(value.span(), "is not known".into(), Some(help.into())))
            }
        };
    }
    let table = inner(value, &["rate", "stress", "stress_rate"])?;
    match (table.get("rate"), table.get("stress"), table.get("stress_rate")) {
        (Some(rate), None, None) => {
            let absolute = matches!(rate.get_ref(), DeValue::String(_));
            let unit = if absolute { Dimension::RATE } else { Dimension::NUMBER };
            Ok((Drive::Rate(number(rate, unit, [-1e9, 1e9])?), absolute))
        }
        (None, None, None) | (Some(_), ..) => {
            let help = "give rate, or stress with or without stress_rate";
            Err(Mistake(value.span(), "does not say what is done".into(), Some(help.into())))
        }
        (None, stress, rate) => Ok((Drive::Stress(target(stress, rate, Dimension::STRESS_RATE)?), false)),
    }
}

/// A stress, which may be "current", and how fast it moves.
fn target(stress: Option<&Node<'_>>, rate: Option<&Node<'_>>, rate_unit: Dimension) -> Parsed<Target> {
    let value = match stress.map(|value| (value, value.get_ref())) {
        None => None,
        Some((_, DeValue::String(word))) if word == "current" => None,
        Some((value, _)) => Some(number(value, Dimension::STRESS, ANY_STRESS)?),
    };
    let rate = rate.map_or(Ok(0.0), |rate| number(rate, rate_unit, ANY_RATE))?;
    Ok(Target { value, rate })
}

fn six(value: &Node<'_>, dimension: Dimension) -> Parsed<[f64; 6]> {
    let wrong = || {
        let why = "is no list of six numbers, one each for xx, yy, zz, yz, zx, xy";
        Mistake(value.span(), why.into(), None)
    };
    let DeValue::Array(items) = value.get_ref() else { return Err(wrong()) };
    let numbers: Vec<f64> =
        items.iter().map(|item| number(item, dimension, ANY_STRESS)).collect::<Parsed<_>>()?;
    numbers.try_into().map_err(|_| wrong())
}

fn constraint(value: &Node<'_>) -> Parsed<Constraint> {
    let table = inner(value, &["stress", "strain", "value", "rate", "moves"])?;
    let list = |key: &str, unit| table.get(key).map_or(Ok([0.0; 6]), |value| six(value, unit));
    let stress = list("stress", Dimension::NUMBER)?;
    let held = stress != [0.0; 6];
    let strain = list("strain", if held { Dimension::STRESS } else { Dimension::NUMBER })?;
    if !held && strain == [0.0; 6] {
        let help = "give stress or strain, e.g. stress = [1, 1, 1, 0, 0, 0]";
        return Err(Mistake(value.span(), "combines nothing".into(), Some(help.into())));
    }
    if let (false, Some(value)) = (held, table.get("value").or(table.get("moves"))) {
        return Err(Mistake(value.span(), "belongs to a combination of stresses".into(), None));
    }
    let unit = if held { Dimension::STRESS_RATE } else { Dimension::NUMBER };
    let target = target(table.get("value"), table.get("rate"), unit)?;
    let moves = table.get("moves").map(|value| six(value, Dimension::NUMBER)).transpose()?;
    Ok(Constraint { strain, stress, target, moves })
}

/// The measure of a name.
fn measure(name: &str, span: Range<usize>) -> Parsed<Measure> {
    Measure::named(name).ok_or_else(|| {
        let names = Measure::ALL.iter().map(|(name, _, _)| *name);
        let others = ["reversals", "unbalanced_force", "critical_state"];
        Mistake(span, "is no measure".into(), Some(meant(name, names.chain(others))))
    })
}

fn end(key: &str, value: &Node<'_>) -> Parsed<Until> {
    match key {
        "reversals" => {
            let count = number(value, Dimension::NUMBER, [1.0, 1e9])?;
            if count.fract() != 0.0 {
                return Err(Mistake(value.span(), "is not a whole number".into(), None));
            }
            Ok(Until::Reversals(count as u64))
        }
        "unbalanced_force" => {
            Ok(Until::AtRest { unbalanced_force: number(value, Dimension::NUMBER, [1e-9, 1.0])? })
        }
        "critical_state" => {
            let table = inner(value, &CRITICAL.map(|(name, _)| name))?;
            let [window, stress_ratio, volumetric_strain] = CRITICAL.map(|(name, default)| {
                table.get(name).map_or(Ok(default), |value| number(value, Dimension::NUMBER, [1e-9, 100.0]))
            });
            Ok(Until::CriticalState {
                window: window?,
                stress_ratio: stress_ratio?,
                volumetric_strain: volumetric_strain?,
            })
        }
        _ => {
            let measure = measure(key, value.span())?;
            Ok(Until::Reaches { measure, value: number(value, dimension(measure.unit()), ANY_STRESS)? })
        }
    }
}

fn measured(table: &DeTable<'_>, span: Range<usize>) -> Parsed<Measure> {
    match table.get("measure") {
        None => Ok(Measure::ArcLength),
        Some(value) => measure(&text(value)?, value.span()),
    }
    .map_err(|Mistake(at, why, help)| Mistake(if at.is_empty() { span } else { at }, why, help))
}

fn turns(value: &Node<'_>) -> Parsed<Turns> {
    let table = inner(value, &["measure", "high", "low"])?;
    let measure = measured(table, value.span())?;
    let unit = dimension(measure.unit());
    let (Some(high), Some(low)) = (table.get("high"), table.get("low")) else {
        let help = "e.g. turns = { measure = \"xx_strain\", high = 0.01, low = -0.01 }";
        return Err(Mistake(value.span(), "needs high and low".into(), Some(help.into())));
    };
    let (high, low) = (number(high, unit, ANY_STRESS)?, number(low, unit, ANY_STRESS)?);
    if low >= high {
        return Err(Mistake(value.span(), "has a low that is not below its high".into(), None));
    }
    Ok(Turns { measure, high, low })
}

fn record(value: &Node<'_>) -> Parsed<Record> {
    let table = inner(value, &["measure", "every", "states", "end", "at"])?;
    let measure = measured(table, value.span())?;
    let unit = dimension(measure.unit());
    let positive = |value: &Node<'_>| number(value, unit, [1e-12, 1e12]);
    match (table.get("every"), table.get("states"), table.get("end"), table.get("at")) {
        (Some(every), None, None, None) => Ok(Record::every(measure, positive(every)?)),
        (None, Some(states), Some(end), None) => {
            let count = number(states, Dimension::NUMBER, [1.0, 1e6])?;
            Ok(Record::equal(measure, count as usize, positive(end)?))
        }
        (None, None, None, Some(places)) => {
            let DeValue::Array(items) = places.get_ref() else {
                return Err(Mistake(places.span(), "is no list".into(), None));
            };
            let places: Vec<f64> = items.iter().map(positive).collect::<Parsed<_>>()?;
            if places.is_empty() || places.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err(Mistake(value.span(), "does not rise from value to value".into(), None));
            }
            Ok(Record { measure, states: 0, spacing: Spacing::Strains(places), end: f64::INFINITY })
        }
        _ => {
            let help = "give every, or states and end, or at = [...]";
            Err(Mistake(value.span(), "does not say where states stand".into(), Some(help.into())))
        }
    }
}
