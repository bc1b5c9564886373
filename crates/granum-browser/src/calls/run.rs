//! A run that goes on a piece at a time.

use std::time::Duration;

use granum_core::observer::Progress;
use granum_io::{Case, RunKind};
use granum_run::Source;
use serde_json::{Value, json};

use super::case::NAME;
use crate::answer::CallError;
use crate::pace::Pace;
use crate::page::{Arguments, Page};

/// How long a piece takes where nothing is said, ms.
const PIECE: f64 = 100.0;

/// Begins a run of a case, in place of the one before. Its grains are placed.
pub(super) fn begin(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let case = Case::parse(arguments.text("case")?, NAME)?;
    let mut pace = Pace::new(Duration::MAX);
    page.run = None;
    page.run = Some(page.laboratory.in_pieces(RunKind::Test, &case, &Source::Case, &mut pace)?);
    Ok(json!({ "grains": case.grains.count, "warnings": pace.warnings }))
}

/// Goes on for about so many `milliseconds`.
pub(super) fn go_on(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let milliseconds = arguments.number_or("milliseconds", PIECE).clamp(0.0, 1e9);
    let mut pace = Pace::new(Duration::from_secs_f64(milliseconds / 1e3));
    page.run()?;
    let Some(run) = &mut page.run else { return Ok(Value::Null) };
    let status = run.go_on(&mut pace)?;
    let record = run.record();
    Ok(json!({
        "status": status,
        "phase": record.phase,
        "progress": pace.last.as_ref().map(progress),
        "states": run.states().len(),
        "steps": record.steps,
        "warnings": pace.warnings,
        "notes": record.notes,
    }))
}

fn progress(progress: &Progress) -> Value {
    json!({
        "activity": progress.activity, "part": progress.part, "done": progress.done, "fraction": progress.fraction,
        "values": progress.values,
    })
}

/// The states recorded `from` a number on: the columns with their units, and the values of each state in their order.
pub(super) fn states(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let states = page.run()?.states();
    let from = (arguments.number_or("from", 0.0).max(0.0) as usize).min(states.len());
    let columns: Vec<Value> = states.first().map_or_else(Vec::new, |state| {
        state.values.iter().map(|value| json!({ "name": value.name, "unit": value.unit })).collect()
    });
    let rows: Vec<Vec<Value>> = states[from..]
        .iter()
        .map(|state| state.values.iter().map(|value| number(value.value)).collect())
        .collect();
    Ok(json!({ "columns": columns, "rows": rows }))
}

/// A number in JSON, which has none for NaN and infinity: null is what is not known, and a word what is infinite.
fn number(value: f64) -> Value {
    match value {
        f64::INFINITY => json!("inf"),
        f64::NEG_INFINITY => json!("-inf"),
        value => json!(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_finite_number_is_told_apart() {
        let row: Vec<Value> =
            [1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().map(number).collect();
        assert_eq!(json!(row).to_string(), r#"[1.0,null,"inf","-inf"]"#);
    }
}
