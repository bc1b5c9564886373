//! The inputs of a prediction from the command line, and what is said of them.

use std::path::Path;

use granum_core::Table;
use granum_core::names::nearest;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_io::case::{Fields, Vocabulary};
use granum_io::read_columns;
use granum_io::sheet::read_inputs;
use granum_learn::surrogate::{Outside, UnseenCombination};
use serde_json::{Value, json};

use super::family_chart::short;
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::apart_from_range;

/// Nominal coverage of the intervals for states of unseen runs.
pub(super) const LEVEL: f64 = 0.9;

/// The dimension of an input: that of its unit, or else that of the quantity of its name, which may be a column of a sensor, a
/// parameter of a path or a key of the case.
pub(super) fn dimension(vocabulary: &Vocabulary, name: &str, unit: &str) -> Dimension {
    let of_sensor = || {
        vocabulary
            .sensors()
            .columns()
            .find(|column| column.name == name)
            .map(|column| column.unit.to_string())
    };
    let of_path = || {
        let parameter = vocabulary.paths().all().iter().find_map(|preset| preset.parameter(name));
        parameter.map(|parameter| parameter.unit.to_string())
    };
    let of_case = || {
        let fields = Fields::new(vocabulary);
        fields.iter().find(|field| field.key == name || field.path() == name).map(|field| field.si_unit())
    };
    let given = (!unit.is_empty()).then(|| unit.to_string());
    let unit = given.or_else(of_sensor).or_else(of_path).or_else(of_case).unwrap_or_default();
    DIMENSIONS.into_iter().find(|known| known.si_unit() == unit).unwrap_or(Dimension::NUMBER)
}

/// The rows of a file: a table of the inputs and, of the optional columns, of those that it has. The header of a CSV may give units.
pub(super) fn rows(
    context: &Context,
    path: &Path,
    names: &[&str],
    optional: &[&str],
    unit: &dyn Fn(&str) -> String,
) -> Result<Table, Failure> {
    let is_csv = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    if is_csv {
        let of = |name: &str| dimension(context.vocabulary(), name, &unit(name));
        let read = |optional: &[&str]| read_inputs(path, names, optional, &of);
        // An optional column of words is passed over.
        return Ok(read(optional).or_else(|error| if optional.is_empty() { Err(error) } else { read(&[]) })?);
    }
    let all: Vec<&str> = names.iter().chain(optional).copied().collect();
    match optional.is_empty() {
        true => Ok(read_columns(path, names)?),
        false => Ok(read_columns(path, &all).or_else(|_| read_columns(path, names))?),
    }
}

/// The dimensions that an input can have.
const DIMENSIONS: [Dimension; 12] = [
    Dimension::STRESS,
    Dimension::LENGTH,
    Dimension::MASS,
    Dimension::TIME,
    Dimension::RATE,
    Dimension::VELOCITY,
    Dimension::FORCE,
    Dimension::STRESS_RATE,
    Dimension::DENSITY,
    Dimension::ENERGY,
    Dimension::SURFACE_ENERGY,
    Dimension::ANGLE,
];

/// The row that `--set` flags give, in the order of the inputs; `unit` is the unit of an input where it is known, and `needs` says
/// what the inputs are.
pub(super) fn row(
    context: &Context,
    names: &[String],
    unit: &dyn Fn(&str) -> String,
    flags: &[String],
    needs: &dyn Fn() -> String,
) -> Result<Vec<f64>, Failure> {
    let mut row = vec![None; names.len()];
    for flag in flags {
        let (name, text) = flag
            .split_once('=')
            .ok_or_else(|| Failure::new(format!("--set {flag}: write it as INPUT=VALUE\n{}", needs())))?;
        let k = names.iter().position(|known| known == name.trim()).ok_or_else(|| {
            let near = nearest(name.trim(), names.iter().map(String::as_str));
            let hint = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
            Failure::new(format!("--set {flag}: there is no such input{hint}\n{}", needs()))
        })?;
        let value = parse_quantity(text, dimension(context.vocabulary(), &names[k], &unit(&names[k])))
            .map_err(|why| Failure::new(format!("--set {flag}: {:?} {why}", text.trim())))?;
        if row[k].replace(value).is_some() {
            return Err(Failure::new(format!("--set {flag}: {} is given twice", names[k])));
        }
    }
    let missing: Vec<&str> =
        names.iter().zip(&row).filter(|(_, v)| v.is_none()).map(|(name, _)| name.as_str()).collect();
    if !missing.is_empty() {
        let example = missing.first().map_or(String::new(), |name| format!(" (e.g. --set {name}=VALUE)"));
        return Err(Failure::new(format!("missing: {}{example}\n{}", missing.join(", "), needs())));
    }
    Ok(row.into_iter().flatten().collect())
}

/// A sentence on the inputs that lie outside the trained range.
pub(super) fn outside_text(outside: &[Outside]) -> Option<String> {
    let each = outside.iter().map(|outside| {
        let [low, high] = outside.range;
        let [value, low, high] = apart_from_range(outside.value, [low, high]);
        format!("{} = {value} (trained from {low} to {high})", outside.name)
    });
    let all = each.collect::<Vec<_>>().join(", ");
    (!all.is_empty()).then(|| format!("OUTSIDE the trained range: {all}; do not trust this prediction."))
}

/// What is said of a prediction for two inputs that the training runs do not have together.
pub(super) fn combination_text(combination: Option<&UnseenCombination>) -> Option<String> {
    let [(first, x), (second, y)] = &combination?.inputs;
    let (x, y) = (short(*x), short(*y));
    Some(format!(
        "OUTSIDE what was trained: no run has {first} = {x} and {second} = {y} together, or nearly; the intervals are wider, and a simulation \
         (--check, or a campaign) would tell whether they hold."
    ))
}

/// The same for a document.
pub(super) fn combination_json(combination: Option<&UnseenCombination>) -> Value {
    combination.map_or(Value::Null, |found| {
        let each = found.inputs.iter().map(|(input, value)| json!({ "input": input, "value": value }));
        Value::Array(each.collect())
    })
}
