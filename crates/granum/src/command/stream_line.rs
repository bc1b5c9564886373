//! The lines of `granum stream`: what one asks, and how it is answered.

use std::collections::HashMap;

use granum_core::quantity::{Dimension, parse_quantity};
use granum_learn::Surrogate;
use granum_learn::dataset::Category;
use granum_learn::surrogate::{Prediction, PredictionStream};
use serde_json::{Map, Value, json};

use super::prediction_input::dimension;
use super::prediction_words::InputWords;
use crate::context::Context;
use crate::failure::Failure;

/// What a line says of itself, and is given back.
const SEQUENCE: &str = "sequence";
/// Begins a new test.
const RESET: &str = "reset";
/// Gives the units of numbers from there on.
const UNITS: &str = "units";

/// The inputs of a surrogate by the names that lines have, and the names of its answers.
pub(super) struct StreamInputs {
    /// The column of each input that is a number, with its dimension and the factor of its unit.
    numbers: Vec<(String, usize, Dimension, f64)>,
    /// Each category with the columns of its words.
    categories: Vec<(Category, Vec<usize>)>,
    columns: usize,
    /// The beginnings of the entries for each output: mean, standard deviation, lower and upper end.
    outputs: Vec<[String; 4]>,
}

/// The answer to a line.
pub(super) struct Answer {
    sequence: Option<Value>,
    content: Result<String, String>,
}

impl Answer {
    pub fn refused(sequence: Option<Value>, error: String) -> Answer {
        Answer { sequence, content: Err(error) }
    }

    /// Why a line could not be answered.
    pub fn error(&self) -> Option<&str> {
        self.content.as_ref().err().map(String::as_str)
    }

    /// The line of JSON with its end. An answer without prediction says which line it is for.
    pub fn json(&self, line: u64) -> String {
        let sequence = self.sequence.as_ref().map(|sequence| format!("{}:{sequence}", json!(SEQUENCE)));
        let content = match &self.content {
            Ok(content) => content.clone(),
            Err(error) => format!("\"line\":{line},\"error\":{}", json!(error)),
        };
        let all: Vec<String> =
            sequence.into_iter().chain(Some(content).filter(|text| !text.is_empty())).collect();
        format!("{{{}}}\n", all.join(","))
    }
}

impl StreamInputs {
    /// # Errors
    /// If an input has a name that means something else in a line.
    pub fn new(context: &Context, surrogate: &dyn Surrogate) -> Result<StreamInputs, Failure> {
        let columns = surrogate.columns();
        let (names, words) = (columns.input_names(), InputWords::new(columns));
        let place = |name: &str| names.iter().position(|known| known == name).unwrap_or_default();
        if let Some(name) =
            [SEQUENCE, RESET, UNITS].into_iter().find(|name| names.iter().any(|own| own == name))
        {
            return Err(Failure::new(format!(
                "the surrogate has an input `{name}`, a name that has a meaning of its own in a line: it cannot be streamed"
            )));
        }
        let number = |name: &String| {
            let at = place(name);
            let unit = columns.inputs.get(at).map_or("", |input| input.unit.as_str());
            (name.clone(), at, dimension(context.vocabulary(), name, unit), 1.0)
        };
        let category = |category: Category| {
            let places = category.columns().map(|column| place(&column)).collect();
            (category, places)
        };
        let entry = |prefix: &str, name: &str| format!("{}:", json!(format!("{prefix}_{name}")));
        let prefixes = ["predicted", "standard_deviation", "lower", "upper"];
        Ok(StreamInputs {
            numbers: words.numbers.iter().map(number).collect(),
            categories: columns.categories().into_iter().map(category).collect(),
            columns: names.len(),
            outputs: columns
                .output_names()
                .iter()
                .map(|name| prefixes.map(|prefix| entry(prefix, name)))
                .collect(),
        })
    }

    /// The answer to a line. One that is refused changes nothing.
    pub fn answer(&mut self, stream: &mut PredictionStream, line: &[u8]) -> Answer {
        let mut asked = match serde_json::from_slice::<Map<String, Value>>(line) {
            Ok(asked) => asked,
            Err(error) => {
                // Each line is a document of its own.
                let text = error.to_string().replace(" at line 1 column ", " at byte ");
                return Answer::refused(None, format!("the line is not an object of JSON: {text}"));
            }
        };
        let sequence = asked.remove(SEQUENCE);
        let content = match (asked.get(RESET), asked.get(UNITS)) {
            (None, None) => self.state(&asked).and_then(|row| {
                let prediction = stream.next_state(&row).map_err(|error| error.to_string())?;
                Ok(self.prediction(&prediction))
            }),
            (Some(reset), None) => self.alone(&asked, RESET).and_then(|()| match reset {
                Value::Bool(true) => {
                    stream.restart();
                    Ok("\"reset\":true".into())
                }
                other => Err(format!("\"reset\" must be true, not {other}")),
            }),
            (_, Some(units)) => self.alone(&asked, UNITS).and_then(|()| self.set_units(units)),
        };
        Answer { sequence, content }
    }

    /// Refuses a line that is no state and yet has inputs, which would be lost.
    fn alone(&self, asked: &Map<String, Value>, key: &str) -> Result<(), String> {
        let is_input = |name: &String| self.numbers.iter().any(|(known, ..)| known == name);
        match asked
            .keys()
            .find(|name| *name != key && (is_input(name) || [RESET, UNITS].contains(&name.as_str())))
        {
            Some(name) => Err(format!("\"{key}\" stands alone in a line, and this one has {name} as well")),
            None => Ok(()),
        }
    }

    fn set_units(&mut self, units: &Value) -> Result<String, String> {
        let Value::Object(units) = units else {
            return Err(format!("\"units\" must be an object of names and units, not {units}"));
        };
        let mut factors = HashMap::new();
        for (name, unit) in units {
            let Some((_, _, dimension, _)) = self.numbers.iter().find(|(known, ..)| known == name) else {
                return Err(format!("units: there is no input {name}; there are {}", self.names()));
            };
            let Value::String(unit) = unit else {
                return Err(format!("units: the unit of {name} must be a text, not {unit}"));
            };
            let factor = parse_quantity(&format!("1 {unit}"), *dimension);
            factors.insert(name.clone(), factor.map_err(|why| format!("units: {name}: {why}"))?);
        }
        for (name, _, _, factor) in &mut self.numbers {
            *factor = factors.get(name).copied().unwrap_or(*factor);
        }
        Ok(format!("\"units\":{}", json!(units)))
    }

    /// The row of a state.
    fn state(&self, asked: &Map<String, Value>) -> Result<Vec<f64>, String> {
        let mut row = vec![0.0; self.columns];
        let mut missing = Vec::new();
        for (name, place, dimension, factor) in &self.numbers {
            row[*place] = match asked.get(name) {
                None => {
                    missing.push(name.as_str());
                    continue;
                }
                Some(Value::Number(number)) => factor * number.as_f64().unwrap_or(f64::NAN),
                Some(Value::String(text)) => {
                    parse_quantity(text, *dimension).map_err(|why| format!("{name}: {text:?} {why}"))?
                }
                Some(other) => {
                    return Err(format!("{name} must be a number or a text with a unit, not {other}"));
                }
            };
            if !row[*place].is_finite() {
                return Err(format!("{name} is {}, not a finite number", row[*place]));
            }
        }
        for (category, places) in &self.categories {
            match asked.get(&category.name) {
                None => missing.push(category.name.as_str()),
                Some(word) => {
                    let known = |known: &String| Some(known.as_str()) == word.as_str();
                    let place = category.words.iter().position(known);
                    let place = place.ok_or_else(|| {
                        let (name, words) = (&category.name, category.words.join(" or "));
                        format!("{name} must be {words}, not {word}")
                    })?;
                    row[places[place]] = 1.0;
                }
            }
        }
        if !missing.is_empty() {
            return Err(format!("missing: {}; a state has {}", missing.join(", "), self.names()));
        }
        Ok(row)
    }

    fn names(&self) -> String {
        let numbers = self.numbers.iter().map(|(name, ..)| name.as_str());
        numbers
            .chain(self.categories.iter().map(|(known, _)| known.name.as_str()))
            .collect::<Vec<_>>()
            .join(", ")
    }

    fn prediction(&self, prediction: &Prediction) -> String {
        let mut entries = Vec::with_capacity(4 * self.outputs.len() + 1);
        for ([mean, deviation, lower, upper], estimate) in self.outputs.iter().zip(&prediction.values) {
            entries.push(format!("{mean}{}", json!(estimate.mean)));
            if let Some(interval) = &estimate.interval {
                entries.push(format!("{deviation}{}", json!(interval.standard_deviation())));
                entries.push(format!("{lower}{}", json!(interval.lower)));
                entries.push(format!("{upper}{}", json!(interval.upper)));
            }
        }
        let outside = prediction.outside.iter();
        let outside: Vec<Value> =
            outside.map(|o| json!({ "input": o.name, "value": o.value, "range": o.range })).collect();
        entries.push(format!("\"outside\":{}", json!(outside)));
        if let Some(combination) =
            super::prediction_input::combination_json(prediction.combination.as_ref()).as_array()
        {
            entries.push(format!("\"unseen_combination\":{}", json!(combination)));
        }
        entries.join(",")
    }
}
