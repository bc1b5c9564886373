//! What a run has found.

use granum_core::Parts;
use granum_io::formats::csv;
use granum_report::viewer::{View, data};
use granum_run::laboratory::{END, SAMPLE};
use granum_sensors::RecordedState;
use serde_json::{Value, json};

use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// The most contact forces of a view of a run under way.
const FORCES: f64 = 3000.0;

/// The grains and forces as they are now, for the viewer of grains.
pub(super) fn view(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let Some(state) = page.run()?.state() else { return Ok(Value::Null) };
    let strongest = arguments.number_or("strongest", FORCES).clamp(0.0, 1e6) as usize;
    Ok(data(&state.assembly(), Parts::all(), &View::default().with(|view| view.strongest = strongest)))
}

/// The run under way as one text, from which `granum resume` goes on; null once it is complete.
pub(super) fn saved(page: &mut Page, _: &Arguments) -> Result<Value, CallError> {
    let saved = page.run()?.saved()?;
    Ok(json!({ "run": saved.map(|saved| saved.to_json()).transpose()? }))
}

/// The digest that the folder of this run would have.
pub(super) fn digest(page: &mut Page, _: &Arguments) -> Result<Value, CallError> {
    Ok(json!({ "digest": page.run()?.digest()? }))
}

/// The series of the states so far as a table of numbers with commas.
pub(super) fn series(page: &mut Page, _: &Arguments) -> Result<Value, CallError> {
    let record = RecordedState::record(page.run()?.states());
    let mut text = Vec::new();
    csv::write_rows(&mut text, &record.series).map_err(|error| CallError::Message(error.to_string()))?;
    Ok(json!({ "csv": String::from_utf8_lossy(&text) }))
}

/// What a report of the run is made of ([`super::reports`]): case, record, states, and unless `assemblies` is false the first and last assembly.
pub(super) fn result(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let run = page.run()?;
    let snapshot = |name: &str| run.snapshots().get(name).filter(|_| arguments.value("assemblies") != false);
    Ok(json!({
        "case": run.case().resolved_toml(),
        "record": run.record(),
        // A NaN has no number in JSON, but a place in these lines.
        "states": run.states().iter().map(RecordedState::to_line).collect::<Vec<_>>(),
        "start": snapshot(SAMPLE),
        "end": snapshot(END),
    }))
}
