//! One key of the case file: its position, meaning and bounds, and the functions that transfer it to and from a [`Case`].

use super::definition::Case;
use super::shape_value::{self as shape, SHAPE};
use super::sieve;
use granum_core::quantity::{Dimension, format_number, parse_quantity};
use granum_dem::contact::LawParameter;
use granum_dem::contact::choice::check;
use granum_dem::contact::choice::registry::Laws;
use granum_dem::shape::{ShapeKind, ShapeParameter};
use granum_dem::sizes;
use granum_sensors::{DeclaredParameter, ParameterDefault, SensorParameter};

/// A value of a field in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A quantity, or `None` for the keyword of the field ("none", "auto").
    Number(Option<f64>),
    /// A whole number.
    Count(u64),
    /// One of the names that the field offers.
    Choice(&'static str),
    /// Quantities in ascending order; empty for the keyword of the field ("none").
    List(Vec<f64>),
    /// Names of what a program knows, in any order; empty where the field's keyword stands ("none").
    Names(Vec<String>),
    /// Points of a sieve curve: diameter, m, and share of the mass that is finer; empty for the keyword ("none").
    Curve(Vec<[f64; 2]>),
    /// Spheres of a shape: centre and radius; empty for the keyword ("none").
    Spheres(Vec<[f64; 4]>),
}

/// "a, b or c".
pub(super) fn any_of(names: &[String]) -> String {
    match names.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

/// The kind of a field's value, with its bounds and access functions.
pub(super) enum FieldKind {
    Number {
        dimension: Dimension,
        /// Smallest and largest value, as quantities.
        bounds: [&'static str; 2],
        /// The word for "not given", with its meaning; `None` if a number is required.
        absent: Option<[&'static str; 2]>,
        get: fn(&Case) -> Option<f64>,
        set: fn(&mut Case, Option<f64>),
    },
    Count {
        bounds: [u64; 2],
        get: fn(&Case) -> u64,
        set: fn(&mut Case, u64),
    },
    List {
        dimension: Dimension,
        /// Smallest and largest of the values, as quantities.
        bounds: [&'static str; 2],
        /// The word for an empty list, with its meaning.
        absent: [&'static str; 2],
        get: fn(&Case) -> Vec<f64>,
        set: fn(&mut Case, Vec<f64>),
    },
    /// Names that are checked where they are used: a program can bring its own.
    Names {
        /// What they are names of.
        what: &'static str,
        /// The word that stands for no name, with its meaning.
        absent: [&'static str; 2],
        get: fn(&Case) -> Vec<String>,
        set: fn(&mut Case, Vec<String>),
    },
    Choice {
        /// Name and meaning of each option.
        options: Vec<[&'static str; 2]>,
        get: fn(&Case) -> &'static str,
        set: fn(&mut Case, &str),
    },
    /// A parameter of contact laws, in use where one of the chosen laws has it.
    Law(&'static LawParameter),
    /// A parameter of size distributions, in use where the chosen one has it.
    Size(&'static sizes::SizeParameter),
    /// A parameter of sensors, with the word for "not given" and its meaning where it can be left out, and whether the sensors are
    /// granum's.
    Sensor {
        parameter: SensorParameter,
        absent: Option<[&'static str; 2]>,
        of_granum: bool,
    },
    /// A parameter of families of shapes, in use where the chosen one has it.
    Shape(&'static ShapeParameter),
    /// The spheres of a shape.
    Spheres {
        /// The word for no list, with its meaning.
        absent: [&'static str; 2],
        get: fn(&Case) -> Vec<[f64; 4]>,
        set: fn(&mut Case, Vec<[f64; 4]>),
    },
    /// A sieve curve.
    Curve {
        /// The word for no curve, with its meaning.
        absent: [&'static str; 2],
        get: fn(&Case) -> Vec<[f64; 2]>,
        set: fn(&mut Case, Vec<[f64; 2]>),
    },
}

/// One key of the case file.
pub struct Field {
    /// Section, e.g. `grains.material`.
    pub section: &'static str,
    /// Key, e.g. `youngs_modulus`.
    pub key: &'static str,
    /// Its meaning, in one or two sentences.
    pub help: String,
    /// The default as a user would write it.
    pub example: String,
    pub(super) kind: FieldKind,
}

impl Field {
    /// The field of a parameter of contact laws.
    pub(super) fn of_law(parameter: &'static LawParameter, laws: &Laws) -> Field {
        let laws = laws.laws_with(parameter);
        let help = format!("{}; {laws}.", parameter.meaning.trim_end_matches('.'));
        let example = with_unit(parameter.default, parameter);
        Field { section: "contact", key: parameter.key, help, example, kind: FieldKind::Law(parameter) }
    }

    /// The field of a parameter of size distributions.
    pub(super) fn of_sizes(parameter: &'static sizes::SizeParameter) -> Field {
        let has = |kind: &&sizes::SizeKind| {
            kind.distribution().description().parameters.iter().any(|known| known.key == parameter.key)
        };
        let names: Vec<String> =
            sizes::ALL.iter().filter(has).map(|kind| format!("distribution = {:?}", kind.name())).collect();
        let help = format!("{}; with {}.", parameter.meaning.trim_end_matches('.'), names.join(" or "));
        let example = format_number(parameter.default);
        Field { section: "grains", key: parameter.key, help, example, kind: FieldKind::Size(parameter) }
    }

    /// The field of a parameter of families of shapes.
    pub(super) fn of_shapes((parameter, kinds): (&'static ShapeParameter, Vec<ShapeKind>)) -> Field {
        let names: Vec<String> = kinds.iter().map(|kind| format!("kind = {:?}", kind.name())).collect();
        let help = format!("{}; with {}.", parameter.meaning.trim_end_matches('.'), any_of(&names));
        let example = format_number(parameter.default);
        Field { section: SHAPE, key: parameter.key, help, example, kind: FieldKind::Shape(parameter) }
    }

    /// True if the field is a parameter of families of shapes.
    pub(super) fn is_of_shapes(&self) -> bool {
        matches!(self.kind, FieldKind::Shape(_))
    }

    /// True if the value of the field is a list of spheres.
    pub(super) fn is_spheres(&self) -> bool {
        matches!(self.kind, FieldKind::Spheres { .. })
    }

    /// The field of a parameter that sensors declare.
    pub(super) fn of_sensor(declared: &DeclaredParameter) -> Field {
        let parameter = declared.parameter;
        let absent = match parameter.default {
            ParameterDefault::Absent(meaning) | ParameterDefault::Needed(meaning) => Some(["none", meaning]),
            _ => None,
        };
        let example = match parameter.default_value() {
            Some(value) => in_si(value, &parameter),
            None => "none".into(),
        };
        let meaning = parameter.meaning.trim_end_matches('.');
        let help = match declared.always {
            true => format!("{meaning}."),
            false => format!("{meaning}; of the sensor {}.", any_of_words(&declared.sensors)),
        };
        Field {
            section: "recording",
            key: parameter.key,
            help,
            example,
            kind: FieldKind::Sensor { parameter, absent, of_granum: declared.of_granum },
        }
    }

    /// True if the field is a parameter of sensors that come with granum.
    pub(super) fn is_of_granum_sensor(&self) -> bool {
        matches!(self.kind, FieldKind::Sensor { of_granum: true, .. })
    }

    /// True if the field is a parameter of sensors.
    pub(super) fn is_of_sensor(&self) -> bool {
        matches!(self.kind, FieldKind::Sensor { .. })
    }

    /// True if the field is a parameter of size distributions.
    pub(super) fn is_of_sizes(&self) -> bool {
        matches!(self.kind, FieldKind::Size(_))
    }

    /// True if the value of the field is a sieve curve.
    pub(super) fn is_curve(&self) -> bool {
        matches!(self.kind, FieldKind::Curve { .. })
    }

    /// The parameter of contact laws that the field is.
    pub(super) fn law_parameter(&self) -> Option<&'static LawParameter> {
        match &self.kind {
            FieldKind::Law(parameter) => Some(parameter),
            _ => None,
        }
    }

    /// True if the field is a parameter of contact laws.
    pub(super) fn is_of_law(&self) -> bool {
        matches!(self.kind, FieldKind::Law(_))
    }

    /// True if the field is a parameter of contact laws and this value is its default.
    pub(super) fn is_default_of_law(&self, value: &Option<Value>) -> bool {
        matches!(&self.kind, FieldKind::Law(parameter) if *value == Some(Value::Number(Some(parameter.default))))
    }

    /// Section and key, e.g. `grains.material.youngs_modulus`.
    pub fn path(&self) -> String {
        format!("{}.{}", self.section, self.key)
    }

    /// The value of this field in a case; `None` for the form of the rate that is not in use.
    pub fn value(&self, case: &Case) -> Option<Value> {
        if self.section == SHAPE && case.has_shape_tables() {
            return None;
        }
        match &self.kind {
            FieldKind::Number { get, absent, .. } => match (get(case), absent) {
                (None, None) => None,
                (value, _) => Some(Value::Number(value)),
            },
            FieldKind::Count { get, .. } => Some(Value::Count(get(case))),
            FieldKind::Choice { get, .. } => Some(Value::Choice(get(case))),
            FieldKind::List { get, .. } => Some(Value::List(get(case))),
            FieldKind::Names { get, .. } => Some(Value::Names(get(case))),
            FieldKind::Law(parameter) => {
                let used = check::parameters_of(&case.contact);
                let known = used.into_iter().find(|known| known.key == parameter.key)?;
                Some(Value::Number(Some(case.contact.parameters.value(known))))
            }
            FieldKind::Size(parameter) => {
                let used = case.grains.sizes.distribution.distribution().description().parameters;
                let known = used.iter().find(|known| known.key == parameter.key)?;
                Some(Value::Number(Some(case.grains.sizes.value(known))))
            }
            FieldKind::Sensor { parameter, .. } => Some(Value::Number(parameter.value(&case.recording))),
            FieldKind::Shape(parameter) => {
                let entry = shape::only(case);
                let used = entry.kind.family().description().parameters;
                let known = used.iter().find(|known| known.key == parameter.key)?;
                Some(Value::Number(Some(entry.value(known))))
            }
            FieldKind::Spheres { get, .. } => {
                let used = shape::only(case).kind.family().description().takes_spheres;
                used.then(|| Value::Spheres(get(case)))
            }
            FieldKind::Curve { get, .. } => Some(Value::Curve(get(case))),
        }
    }

    /// True if the value of the field is a list.
    pub fn is_list(&self) -> bool {
        matches!(self.kind, FieldKind::List { .. } | FieldKind::Names { .. })
    }

    /// True if the field takes a list of names.
    pub(super) fn is_names(&self) -> bool {
        matches!(self.kind, FieldKind::Names { .. })
    }

    /// True if the value of the field is a number that may have a fractional part.
    pub(super) fn is_real(&self) -> bool {
        matches!(
            self.kind,
            FieldKind::Number { .. }
                | FieldKind::Law(_)
                | FieldKind::Size(_)
                | FieldKind::Shape(ShapeParameter { whole: false, .. })
                | FieldKind::Sensor { .. }
        )
    }

    /// True if the value of the field is one of several names.
    pub(super) fn is_choice(&self) -> bool {
        matches!(self.kind, FieldKind::Choice { .. })
    }

    /// The value of this field in a case in the form of a case file, e.g. `300` or `"auto"`; empty where it is not in use.
    pub fn shown(&self, case: &Case) -> String {
        self.value(case).map_or_else(String::new, |value| self.toml(&value))
    }

    /// Sets a value in a case. A value whose kind differs from that of the field is ignored.
    pub fn apply(&self, case: &mut Case, value: Value) {
        match (&self.kind, value) {
            (FieldKind::Number { set, .. }, Value::Number(value)) => set(case, value),
            (FieldKind::Count { set, .. }, Value::Count(value)) => set(case, value),
            (FieldKind::Choice { set, .. }, Value::Choice(value)) => set(case, value),
            (FieldKind::List { set, .. }, Value::List(value)) => set(case, value),
            (FieldKind::Names { set, .. }, Value::Names(value)) => set(case, value),
            (FieldKind::Curve { set, .. }, Value::Curve(points)) => set(case, points),
            (FieldKind::Spheres { set, .. }, Value::Spheres(spheres)) => set(case, spheres),
            (FieldKind::Shape(parameter), Value::Number(Some(value))) => {
                shape::change(case, |entry| {
                    // As with laws, the default counts as not given.
                    let used = entry.kind.family().description().parameters;
                    let known = used.iter().find(|known| known.key == parameter.key);
                    if known.is_some_and(|known| known.default == value) {
                        entry.values.remove(parameter.key);
                    } else {
                        entry.values.insert(parameter.key.to_string(), value);
                    }
                });
            }
            (FieldKind::Size(parameter), Value::Number(Some(value))) => {
                case.grains.sizes.values.insert(parameter.key.to_string(), value);
            }
            (FieldKind::Sensor { parameter, .. }, Value::Number(value)) => {
                // As with laws, the default counts as not given.
                match value.filter(|value| parameter.default_value() != Some(*value)) {
                    Some(value) => case.recording.parameters.insert(parameter.key.to_string(), value),
                    None => case.recording.parameters.remove(parameter.key),
                };
            }
            (FieldKind::Law(parameter), Value::Number(Some(value))) => {
                // The default counts as not given, so that a case with every key written out is the same case.
                if value == parameter.default {
                    case.contact.parameters.unset(parameter.key);
                } else {
                    // There is room for all parameters that are registered.
                    let _ = case.contact.parameters.set(parameter.key, value);
                }
            }
            _ => {}
        }
    }

    pub(super) fn number_bounds(&self) -> [f64; 2] {
        match &self.kind {
            // A bound that cannot be read would be NaN and reject every value; a test reads all bounds.
            FieldKind::Number { bounds, dimension, .. } | FieldKind::List { bounds, dimension, .. } => {
                bounds.map(|bound| parse_quantity(bound, *dimension).unwrap_or(f64::NAN))
            }
            FieldKind::Law(parameter) => parameter.bounds,
            FieldKind::Size(parameter) => parameter.bounds,
            FieldKind::Shape(parameter) => parameter.bounds,
            FieldKind::Sensor { parameter, .. } => parameter.bounds,
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// "from 0 to 1", "\"hertz\" or \"jkr\"", "a list of increasing values from 0 to 1".
    pub fn bounds_text(&self) -> String {
        match &self.kind {
            FieldKind::Number { bounds: [low, high], .. } => format!("from {low} to {high}"),
            FieldKind::Count { bounds: [low, high], .. } => format!("from {low} to {high}"),
            FieldKind::Law(parameter) => {
                let [low, high] = parameter.bounds.map(|bound| with_unit(bound, parameter));
                format!("from {low} to {high}")
            }
            FieldKind::Size(parameter) => {
                let [low, high] = parameter.bounds.map(format_number);
                format!("from {low} to {high}")
            }
            FieldKind::Sensor { parameter, .. } => {
                let [low, high] = parameter.bounds.map(|bound| in_si(bound, parameter));
                format!("from {low} to {high}")
            }
            FieldKind::Shape(parameter) => {
                let [low, high] = parameter.bounds.map(format_number);
                format!("from {low} to {high}")
            }
            FieldKind::Spheres { .. } => "a list of spheres [x, y, z, radius]".into(),
            FieldKind::Curve { .. } => sieve::bounds_text(),
            FieldKind::Choice { options, .. } => {
                let names: Vec<_> = options.iter().map(|[name, _]| format!("\"{name}\"")).collect();
                any_of(&names)
            }
            FieldKind::List { bounds: [low, high], .. } => {
                format!("a list of increasing values from {low} to {high}")
            }
            FieldKind::Names { what, .. } => {
                format!("a list of {what} names")
            }
        }
    }

    /// The keyword or the names that the field accepts apart from numbers, each with its meaning.
    pub(super) fn words(&self) -> &[[&'static str; 2]] {
        match &self.kind {
            FieldKind::Number { absent, .. } | FieldKind::Sensor { absent, .. } => absent.as_slice(),
            FieldKind::Choice { options, .. } => options,
            FieldKind::List { absent, .. }
            | FieldKind::Names { absent, .. }
            | FieldKind::Spheres { absent, .. }
            | FieldKind::Curve { absent, .. } => std::slice::from_ref(absent),
            FieldKind::Count { .. } | FieldKind::Law(_) | FieldKind::Size(_) | FieldKind::Shape(_) => &[],
        }
    }

    /// The value as TOML in SI units.
    pub(super) fn toml(&self, value: &Value) -> String {
        match value {
            Value::Number(Some(value)) => format_number(*value),
            Value::Number(None) => format!("\"{}\"", self.words().first().map_or("none", |[word, _]| word)),
            Value::Count(value) => value.to_string(),
            Value::Choice(name) => format!("\"{name}\""),
            Value::Curve(points) if points.is_empty() => self.toml(&Value::Number(None)),
            Value::Spheres(spheres) if spheres.is_empty() => self.toml(&Value::Number(None)),
            Value::Spheres(spheres) => shape::spheres_toml(spheres),
            Value::Curve(points) => sieve::toml(points),
            Value::List(values) if values.is_empty() => self.toml(&Value::Number(None)),
            Value::Names(names) if names.is_empty() => self.toml(&Value::Number(None)),
            Value::Names(names) => {
                let names: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
                format!("[{}]", names.join(", "))
            }
            Value::List(values) => {
                let values: Vec<String> = values.iter().copied().map(format_number).collect();
                format!("[{}]", values.join(", "))
            }
        }
    }

    /// The SI unit of the field; empty where there is none.
    pub fn si_unit(&self) -> String {
        match &self.kind {
            FieldKind::Number { .. } | FieldKind::List { .. } | FieldKind::Sensor { .. } => {
                self.dimension().si_unit()
            }
            FieldKind::Law(parameter) => parameter.unit.symbol.to_string(),
            _ => String::new(),
        }
    }

    /// The dimension of a number, a list of numbers or a parameter of sensors.
    pub(super) fn dimension(&self) -> Dimension {
        match &self.kind {
            FieldKind::Number { dimension, .. } | FieldKind::List { dimension, .. } => *dimension,
            FieldKind::Sensor { parameter, .. } => parameter.dimension,
            _ => Dimension::NUMBER,
        }
    }

    /// The value at a relative position between the bounds, for tests that draw random cases.
    #[cfg(test)]
    pub(super) fn draw(&self, place: f64) -> Value {
        match &self.kind {
            FieldKind::Number { absent: Some(_), .. } | FieldKind::Sensor { absent: Some(_), .. }
                if place < 0.2 =>
            {
                Value::Number(None)
            }
            FieldKind::Number { .. } | FieldKind::Law(_) | FieldKind::Size(_) | FieldKind::Sensor { .. } => {
                let [low, high] = self.number_bounds();
                Value::Number(Some((low + place * (high - low)).clamp(low, high)))
            }
            FieldKind::Shape(parameter) => {
                let [low, high] = parameter.bounds;
                let value = low + place * (high - low);
                // Many spheres would take long.
                let few = (low + place * (high - low).min(6.0)).round();
                Value::Number(Some(if parameter.whole { few } else { value }))
            }
            FieldKind::Spheres { .. } => Value::Spheres(vec![[0.0, 0.0, 0.0, 1.0], [place, 0.0, 0.0, 0.9]]),
            FieldKind::Count { bounds: [low, high], .. } => {
                Value::Count(low + (place * (high - low) as f64) as u64 / 2)
            }
            FieldKind::Choice { options, .. } => {
                Value::Choice(options[(place * 0.999 * options.len() as f64) as usize][0])
            }
            FieldKind::Curve { .. } if place < 0.5 => Value::Curve(Vec::new()),
            FieldKind::Curve { .. } => Value::Curve(vec![[1e-4, 0.3 * place], [2e-4, 1.0]]),
            FieldKind::Names { .. } if place < 0.5 => Value::Names(Vec::new()),
            FieldKind::Names { .. } => {
                Value::Names(vec![format!("sensor_{:.0}", 1e3 * place), "fabric".into()])
            }
            FieldKind::List { .. } if place < 0.5 => Value::List(Vec::new()),
            FieldKind::List { .. } => {
                let [low, high] = self.number_bounds();
                Value::List(vec![low, low + (place - 0.5) * (high - low).min(1e-3)])
            }
        }
    }
}

/// A number with the SI unit of a parameter.
fn with_unit(value: f64, parameter: &LawParameter) -> String {
    format!("{} {}", format_number(value), parameter.unit.symbol).trim_end().to_string()
}

/// A number with the SI unit of a parameter of sensors.
fn in_si(value: f64, parameter: &SensorParameter) -> String {
    format!("{} {}", format_number(value), parameter.dimension.si_unit()).trim_end().to_string()
}

/// "a, b or c".
fn any_of_words(words: &[&str]) -> String {
    any_of(&words.iter().map(|word| (*word).to_string()).collect::<Vec<_>>())
}
