//! `granum predict FILE`: predictions of a surrogate that a program saved.

use std::path::Path;

use granum_core::Table;
use granum_io::shell::ShowPath;
use granum_io::{check_output_file, write_table};
use granum_learn::Surrogate;
use granum_learn::inference::{RUN, predict_table};
use granum_learn::surrogate::{Cause, Estimate};
use serde_json::{Value, json};

use super::prediction_input::{LEVEL, combination_json, combination_text, outside_text, row, rows};
use super::prediction_words::InputWords;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// One row, given by flags.
pub fn one(context: &Context, surrogate: &dyn Surrogate, flags: &[String]) -> Result<(), Failure> {
    let columns = surrogate.columns();
    let names = columns.input_names();
    let unit = |name: &str| unit_of(surrogate, name);
    let words = InputWords::new(columns);
    let needs = || format!("the surrogate ({}) needs: {}", surrogate.method(), words.names().join(", "));
    let (given, numbers) = words.given(flags, &needs)?;
    let row = words.row(&names, &given, row(context, &words.numbers, &unit, &numbers, &needs)?);
    let prediction = surrogate.predict_rows(&row, LEVEL)?.pop().unwrap_or_default();
    let named = columns.outputs.iter().zip(&prediction.values);
    let outside = prediction.outside.iter();
    let result = json!({
        "method": surrogate.method(),
        "level": LEVEL,
        "outputs": named.clone().map(|(output, estimate)| as_json(&output.name, estimate)).collect::<Vec<_>>(),
        "outside": outside.map(|o| json!({ "input": o.name, "value": o.value, "range": o.range })).collect::<Vec<_>>(),
        "unseen_combination": combination_json(prediction.combination.as_ref()),
    });
    let combination = combination_text(prediction.combination.as_ref());
    let flags: Vec<String> = outside_text(&prediction.outside).into_iter().chain(combination).collect();
    flags.iter().for_each(|text| context.warn_in_json(text));
    output::say(context, &result, || {
        let mut lines: Vec<String> = named.map(|(output, estimate)| line(&output.name, estimate)).collect();
        lines.extend(flags);
        lines.join("\n")
    })
}

/// The unit of an input, as far as the surrogate knows it.
fn unit_of(surrogate: &dyn Surrogate, name: &str) -> String {
    let column = surrogate.columns().inputs.iter().find(|input| input.name == name);
    column.map_or_else(String::new, |input| input.unit.clone())
}

fn as_json(output: &str, estimate: &Estimate) -> Value {
    let interval = estimate.interval.as_ref();
    let causes = interval.map(|interval| {
        let each = interval.causes.iter().map(|(cause, deviation)| (cause.to_string(), json!(deviation)));
        each.collect::<serde_json::Map<String, Value>>()
    });
    json!({
        "output": output,
        "mean": estimate.mean,
        "lower": interval.map(|interval| interval.lower),
        "upper": interval.map(|interval| interval.upper),
        "standard_deviations": causes,
    })
}

/// `stress_ratio = 0.71, 90 % interval 0.65 to 0.77 (standard deviations: noise 0.01, runs 0.03)`.
fn line(output: &str, estimate: &Estimate) -> String {
    let Some(interval) = &estimate.interval else { return format!("{output} = {:.6}", estimate.mean) };
    let each = |(cause, deviation): &(Cause, f64)| format!("{cause} {deviation:.3e}");
    let causes: Vec<String> = interval.causes.iter().map(each).collect();
    let causes = match causes.is_empty() {
        true => String::new(),
        false => format!(" (standard deviations: {})", causes.join(", ")),
    };
    let Estimate { mean, .. } = estimate;
    format!("{output} = {mean:.6}, 90 % interval {:.6} to {:.6}{causes}", interval.lower, interval.upper)
}

/// All rows of a table.
pub fn many(
    context: &Context,
    surrogate: &dyn Surrogate,
    input: &Path,
    output: Option<&Path>,
) -> Result<(), Failure> {
    if let Some(output) = output {
        check_output_file(output, context.force)?;
    }
    let words = InputWords::new(surrogate.columns());
    let inputs: Vec<&str> = words.numbers.iter().map(String::as_str).collect();
    // A column that divides the rows into runs is used if there is one.
    let optional: &[&str] = if inputs.contains(&RUN) { &[] } else { &[RUN] };
    let unit = |name: &str| unit_of(surrogate, name);
    let mut table = match inputs.is_empty() {
        true => Table::default(),
        false => rows(context, input, &inputs, optional, &unit)?,
    };
    words.read_into(&mut table, input)?;
    let predictions = predict_table(surrogate, &table, LEVEL)
        .map_err(|error| Failure::new(format!("{}: {error}", input.shown())))?;
    let outside =
        predictions.values("outside").map_or(0, |flags| flags.iter().filter(|flag| **flag > 0.0).count());
    if outside > 0 {
        let count = predictions.rows();
        context.warn(&format!(
            "{outside} of {count} rows lie outside the range to which the surrogate was fitted (column outside \
             is 1): do not trust their predictions"
        ));
    }
    let Some(path) = output else { return output::put_table(context, None, &predictions) };
    write_table(path, &predictions)?;
    let result = json!({ "output": output::path(path), "rows": predictions.rows(), "rows_outside": outside });
    output::say(context, &result, || format!("wrote {} rows to {}", predictions.rows(), path.shown()))
}
