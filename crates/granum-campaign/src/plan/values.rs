//! The values of variables: at a point of a design, in a row, and in a run.

use granum_core::quantity::format_number;
use granum_simd::power;
use serde::{Deserialize, Serialize};

use super::definition::{Choice, PlanVariable, VariableKind};
use super::design::{Axis, Coordinate};
use super::units;

/// The value of a variable in a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RunValue {
    /// A number in SI units.
    Number(f64),
    /// A word.
    Word(String),
}

impl RunValue {
    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            RunValue::Number(number) => Some(*number),
            RunValue::Word(_) => None,
        }
    }
}

impl std::fmt::Display for RunValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RunValue::Number(number) => f.write_str(&format_number(*number)),
            RunValue::Word(word) => f.write_str(word),
        }
    }
}

/// The value of a variable at a point.
#[derive(Clone)]
pub(super) struct Chosen {
    pub(super) value: RunValue,
    /// The text that its keys get.
    pub(super) text: String,
    /// Further keys that it sets.
    pub(super) set: Vec<(String, String)>,
}

impl Chosen {
    /// A number without a unit.
    pub(super) fn number(number: f64) -> Chosen {
        Chosen { value: RunValue::Number(number), text: format_number(number), set: Vec::new() }
    }

    fn of_choice(choice: &Choice) -> Chosen {
        let value = choice.number.map_or_else(|| RunValue::Word(choice.name.clone()), RunValue::Number);
        Chosen { value, text: choice.name.clone(), set: choice.set.clone() }
    }
}

/// How a design chooses the value of a variable.
pub(super) fn axis(variable: &PlanVariable) -> Axis {
    match &variable.kind {
        VariableKind::Choice(choices) => Axis::Levels(choices.len()),
        _ => Axis::Continuous,
    }
}

/// Number of values in a full factorial design.
pub(super) fn levels(variable: &PlanVariable) -> usize {
    match &variable.kind {
        VariableKind::Choice(choices) => choices.len(),
        VariableKind::Range { levels, .. } => levels.unwrap_or(1),
        VariableKind::Expression(_) | VariableKind::Given => 1,
    }
}

/// The value of a variable at a place on its axis.
pub(super) fn chosen(variable: &PlanVariable, at: Coordinate) -> Chosen {
    match (&variable.kind, at) {
        (VariableKind::Choice(choices), Coordinate::Level(level)) => {
            choices.get(level).map_or_else(|| Chosen::number(f64::NAN), Chosen::of_choice)
        }
        (VariableKind::Range { between, logarithmic, levels, .. }, at) => {
            let share = match at {
                Coordinate::Share(share) => share,
                Coordinate::Level(level) => level as f64 / (levels.unwrap_or(2) - 1) as f64,
            };
            Chosen::number(in_steps(between_bounds(*between, *logarithmic, share), variable.step, *between))
        }
        _ => Chosen::number(f64::NAN),
    }
}

/// The number at a share of a range. The bounds themselves are met exactly.
fn between_bounds([from, to]: [f64; 2], logarithmic: bool, share: f64) -> f64 {
    match share {
        0.0 => from,
        1.0 => to,
        _ if logarithmic => from * power(to / from, share),
        _ => from + (to - from) * share,
    }
}

/// A number with six digits, or the nearest multiple of a step: values that can be read in a table and written by hand.
pub(super) fn rounded(number: f64, step: Option<f64>) -> f64 {
    let text = match step {
        Some(step) => format!("{:.11e}", libm::round(number / step) * step),
        None => format!("{number:.5e}"),
    };
    text.parse().unwrap_or(number)
}

/// A number of a range as it is written: with six digits, or the nearest multiple of a step in the range if there is one.
pub fn in_steps(number: f64, step: Option<f64>, range: [f64; 2]) -> f64 {
    match step {
        Some(step) => within(rounded(number, Some(step)), step, range),
        None => rounded(number, None),
    }
}

/// A multiple of a step, or the nearest one in the range if it is outside: 0 is no value of a range from 0.1 in steps of 0.25.
fn within(number: f64, step: f64, [from, to]: [f64; 2]) -> f64 {
    let Some([first, last]) = multiples([from, to], step) else { return number };
    if number < from && !is_bound(number, from) {
        return rounded(first * step, Some(step));
    }
    if number > to && !is_bound(number, to) {
        return rounded(last * step, Some(step));
    }
    number
}

/// The smallest and the largest whole number of steps in a range, up to the rounding of its bounds; none if no multiple lies in it.
pub(super) fn multiples([from, to]: [f64; 2], step: f64) -> Option<[f64; 2]> {
    let nearest = |bound: f64| libm::round(bound / step);
    let at = |bound: f64| is_bound(rounded(nearest(bound) * step, Some(step)), bound);
    let first = if at(from) { nearest(from) } else { (from / step).ceil() };
    let last = if at(to) { nearest(to) } else { (to / step).floor() };
    (first <= last).then_some([first, last])
}

/// True for a number that differs from a bound only as numbers do that are rounded to twelve digits.
fn is_bound(number: f64, bound: f64) -> bool {
    (number - bound).abs() <= 1e-10 * bound.abs()
}

/// The value that a row gives to a variable.
pub(super) fn given(variable: &PlanVariable, text: &str) -> std::result::Result<Chosen, String> {
    if let VariableKind::Choice(choices) = &variable.kind {
        let found = choices.iter().find(|choice| choice.name == text);
        return found.map(Chosen::of_choice).ok_or_else(|| {
            let names: Vec<&str> = choices.iter().map(|choice| choice.name.as_str()).collect();
            format!("is none of its values: {}", names.join(", "))
        });
    }
    if text.is_empty() {
        return Err("is empty".into());
    }
    match units::quantity(text, &variable.unit) {
        Ok(number) => Ok(Chosen { text: text.to_string(), ..Chosen::number(number) }),
        Err(why) if !variable.unit.is_empty() || variable.keys.is_empty() => Err(why),
        Err(_) => Ok(Chosen { value: RunValue::Word(text.into()), text: text.into(), set: Vec::new() }),
    }
}
