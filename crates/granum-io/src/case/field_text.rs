//! Reading the value of a key from text, with its bounds.

use std::path::Path;

use super::field::{Field, FieldKind, Value};
use super::shape_value as shape;
use super::sieve;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_dem::contact::{LawParameter, Unit};

/// Largest number of values of a list.
const LONGEST_LIST: usize = 100_000;

impl Field {
    /// Reads text (a quantity, a keyword or a name) and checks dimension and bounds.
    ///
    /// # Errors
    /// A sentence that continues "key = value": what is wrong and what would be right.
    pub fn parse(&self, text: &str) -> Result<Value, String> {
        match &self.kind {
            FieldKind::Number { absent, .. } | FieldKind::Sensor { absent, .. } => {
                if absent.is_some_and(|[word, _]| word == text.trim()) {
                    return Ok(Value::Number(None));
                }
                let value = parse_quantity(text, self.dimension()).map_err(|why| match absent {
                    Some([word, meaning]) => format!("{why}, or {word:?} ({meaning})"),
                    None => why,
                })?;
                self.check_number(value)
            }
            FieldKind::Law(parameter) => {
                let angle = parameter.unit == Unit::ANGLE;
                let dimension =
                    if angle { Dimension::ANGLE } else { Dimension::of_powers(parameter.unit.powers) };
                let value = parse_quantity(text, dimension);
                self.check_number(value.map_err(|why| in_units_of(parameter, why))?)
            }
            FieldKind::Size(_) => self.check_number(parse_quantity(text, Dimension::NUMBER)?),
            FieldKind::Shape(parameter) => {
                let value = parse_quantity(text, Dimension::NUMBER)?;
                if parameter.whole && value.fract() != 0.0 {
                    return Err(format!("is not a whole number; it must be {}", self.bounds_text()));
                }
                self.check_number(value)
            }
            FieldKind::Spheres { absent: [word, _], .. } => match text.trim() {
                text if text == *word => Ok(Value::Spheres(Vec::new())),
                text => shape::parse_spheres(text).map(Value::Spheres),
            },
            FieldKind::Curve { absent: [word, _], .. } => match text.trim() {
                text if text == *word => Ok(Value::Curve(Vec::new())),
                text if text.starts_with('[') => sieve::parse(text).map(Value::Curve),
                "" => Err(format!("is empty; it must be {}", sieve::bounds_text())),
                file => {
                    let points = sieve::read(Path::new(file));
                    points.map(Value::Curve).map_err(|error| format!("cannot be used: {error}"))
                }
            },
            FieldKind::Count { .. } => {
                let plain = text.trim().replace('_', "");
                match plain.parse::<u64>() {
                    Ok(value) => self.check_count(value),
                    Err(_) => Err(format!("is not a whole number; it must be {}", self.bounds_text())),
                }
            }
            FieldKind::Choice { options, .. } => {
                match options.iter().find(|[name, _]| *name == text.trim()) {
                    Some([name, _]) => Ok(Value::Choice(name)),
                    None => Err(format!("is not known; it must be {}", self.bounds_text())),
                }
            }
            FieldKind::List { absent: [word, _], .. } | FieldKind::Names { absent: [word, _], .. } => {
                let text = text.trim();
                if text == *word {
                    return Ok(match self.kind {
                        FieldKind::Names { .. } => Value::Names(Vec::new()),
                        _ => Value::List(Vec::new()),
                    });
                }
                let inner = text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(text);
                let items: Vec<&str> = inner.split(',').map(|item| item.trim().trim_matches('"')).collect();
                // As in TOML, a list may end with a comma.
                let items = if items.last() == Some(&"") { &items[..items.len() - 1] } else { &items[..] };
                self.parse_list(items.iter().copied()).map_err(|(at, why)| match at {
                    Some(at) => format!("value {} ({:?}) {why}", at + 1, items[at]),
                    None => why,
                })
            }
        }
    }

    /// Reads the values of a list and checks that they are within bounds and in ascending order.
    ///
    /// # Errors
    /// As for [`Field::parse`], with the index (from 0) of the wrong value, if a single one is wrong.
    pub fn parse_list<'a>(
        &self,
        items: impl IntoIterator<Item = &'a str>,
    ) -> Result<Value, (Option<usize>, String)> {
        let dimension = match &self.kind {
            FieldKind::List { dimension, .. } => dimension,
            FieldKind::Names { .. } => return self.parse_names(items),
            _ => return Err((None, format!("is a list; it must be {}", self.bounds_text()))),
        };
        let [low, high] = self.number_bounds();
        let mut values: Vec<f64> = Vec::new();
        for (at, item) in items.into_iter().enumerate() {
            let wrong = |why: String| (Some(at), why);
            let value = parse_quantity(item, *dimension).map_err(wrong)? + 0.0;
            if !(value >= low && value <= high) {
                return Err(wrong(format!("is out of bounds; it must be {}", self.bounds_text())));
            }
            if values.last().is_some_and(|before| *before >= value) {
                return Err(wrong(format!(
                    "is not greater than the one before; it must be {}",
                    self.bounds_text()
                )));
            }
            values.push(value);
        }
        match values.len() {
            0 => Err((None, format!("has no values; it must be {}", self.bounds_text()))),
            1..=LONGEST_LIST => Ok(Value::List(values)),
            many => Err((None, format!("has {many} values; at most {LONGEST_LIST} are possible"))),
        }
    }

    fn parse_names<'a>(
        &self,
        items: impl IntoIterator<Item = &'a str>,
    ) -> Result<Value, (Option<usize>, String)> {
        let mut names: Vec<String> = Vec::new();
        for (at, item) in items.into_iter().enumerate() {
            let plain = |c: u8| c.is_ascii_alphanumeric() || c == b'_' || c == b'-';
            if item.is_empty() || !item.bytes().all(plain) {
                let message = "is not a name: use letters, digits, underscores and hyphens".to_string();
                return Err((Some(at), message));
            }
            if names.iter().any(|known| known == item) {
                return Err((Some(at), "is given twice; leave one out".into()));
            }
            names.push(item.to_string());
        }
        match names.len() {
            0 => Err((None, format!("has no names; it must be {}", self.bounds_text()))),
            1..=LONGEST_LIST => Ok(Value::Names(names)),
            many => Err((None, format!("has {many} names; at most {LONGEST_LIST} are possible"))),
        }
    }

    fn check_number(&self, value: f64) -> Result<Value, String> {
        let [low, high] = self.number_bounds();
        if value >= low && value <= high {
            // Adding zero turns -0 into 0, so that both give the same case.
            return Ok(Value::Number(Some(value + 0.0)));
        }
        Err(format!("is out of bounds; it must be {}", self.bounds_text()))
    }

    fn check_count(&self, value: u64) -> Result<Value, String> {
        match &self.kind {
            FieldKind::Count { bounds: [low, high], .. } if value < *low || value > *high => {
                Err(format!("is out of bounds; it must be {}", self.bounds_text()))
            }
            _ => Ok(Value::Count(value)),
        }
    }
}

/// A stiffness has the dimension of an energy per area; the message names the kind of the parameter instead.
fn in_units_of(parameter: &LawParameter, message: String) -> String {
    if parameter.unit != Unit::STIFFNESS {
        return message;
    }
    let message = message.replace("an energy per area", "a stiffness");
    message.replace("J/m2 or mJ/m2", "N/m, kN/m or MN/m").replace("J/m2", "N/m")
}
