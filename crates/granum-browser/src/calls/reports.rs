//! Reports of results.

use granum_core::Assembly;
use granum_io::{Case, RunRecord};
use granum_report::{Presented, RoleInStudy, RunReport, run_report};
use granum_sensors::{Record, RecordedState};
use serde::Deserialize;
use serde_json::{Value, json};

use super::case::NAME;
use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// What the call `result` of the laboratory gives.
#[derive(Deserialize)]
pub(super) struct Received {
    case: String,
    record: RunRecord,
    states: Vec<String>,
    start: Option<Assembly>,
    end: Option<Assembly>,
}

impl Received {
    /// Reads it.
    pub(super) fn from_value(value: &Value) -> Result<Received, CallError> {
        let received = Received::deserialize(value);
        received.map_err(|error| CallError::Message(format!("this is no result of a run: {error}")))
    }

    /// The text of its case.
    pub(super) fn case(&self) -> &str {
        &self.case
    }
}

/// The measurements of the states of a `result`.
pub(super) fn measurements(page: &Page, result: &Received) -> Result<Record, CallError> {
    let sensors = page.laboratory.registry.vocabulary.sensors();
    let states: Option<Vec<RecordedState>> =
        result.states.iter().map(|line| RecordedState::from_line(line, sensors)).collect();
    let states = states.ok_or_else(|| CallError::Message("a state of the result cannot be read".into()))?;
    Ok(RecordedState::record(&states))
}

/// The `result` of a run.
pub(super) fn received(arguments: &Arguments) -> Result<Received, CallError> {
    Received::from_value(arguments.value("result"))
}

/// What a report is made of: the `result` of a run, with its name.
fn run_report_of(page: &Page, arguments: &Arguments) -> Result<RunReport, CallError> {
    let result = received(arguments)?;
    let case = Case::parse(&result.case, NAME)?;
    let record = measurements(page, &result)?;
    let name = arguments.text("name").unwrap_or("test");
    let mut report = RunReport::of_parts(name, case, result.record, record, RoleInStudy::Single);
    (report.start, report.end) = (result.start, result.end);
    Ok(report)
}

/// What its report says first of the `result` of a run.
pub(super) fn presented(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    Ok(Presented::of_run(&run_report_of(page, arguments)?).to_json())
}

/// The report of the `result` of a run as one page, and its figures by their names.
pub(super) fn report(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let document = run_report(&run_report_of(page, arguments)?);
    Ok(json!({ "html": document.html, "figures": document.figures }))
}
