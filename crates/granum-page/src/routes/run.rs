//! One run: what it is, how far it is, what it found.

use granum_core::Table;
use granum_io::shell::ShowPath;
use granum_io::{OutputFolder, Run, RunKind, RunRecord, RunStatus};
use granum_report::{Presented, RoleInStudy, RunReport};
use granum_run::runs_table::{RunEntry, RunsTable, Selection};
use serde_json::{Value, json};

use crate::answer::{Answer, Answered};
use crate::commands;
use crate::listing::word;
use crate::numbers::number;
use crate::program::Next;
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Columns of a table of runs that are no measures of a run.
const NO_MEASURES: [&str; 3] = ["checks", "checks_failed", "grains"];

/// Everything but its figures: `path`.
pub fn run(site: &Site, query: &Query) -> Answered {
    let path = query.needed("path")?;
    let run = site.run(path)?;
    let wrong = |error: granum_io::Error| Refused::unreadable(site.without_root(error));
    let (case, record) = (run.case().map_err(wrong)?, run.record().map_err(wrong)?);
    let series = series(&run, &record);
    let end = case.test_definition().deviator_strain_end().filter(|_| record.kind != RunKind::Sample);
    let named = site.folder.as_named(path);
    // Of a run that is under way its record says as little as of one that was killed; there is nothing to do but to watch it.
    let next = match OutputFolder::is_in_use(run.path()) {
        true => Next::default(),
        false => site.program.next(run.path(), &named).unwrap_or_default(),
    };
    let snapshots = run.snapshots().unwrap_or_default();
    let is_test = record.kind == RunKind::Test;
    let mut lines = commands::of_run(&named, is_test, !snapshots.is_empty());
    commands::add_next(&mut lines, next.command);
    let columns = |table: &Table| -> Value {
        table.columns().iter().map(|column| json!({ "name": column.name, "unit": column.unit })).collect()
    };
    let entry = RunEntry::new(path, run.path(), case.clone(), record.clone());
    let seconds: f64 = record.wall_seconds.values().sum();
    Ok(Answer::Json(json!({
        "path": path,
        "name": run.path().file_name().map_or_else(|| named.shown(), |name| name.to_string_lossy().into_owned()),
        "what": if is_test { "test" } else { "sample" },
        "progress": progress_of(&run, &record, series.as_ref(), end),
        "grains": record.grains,
        "engine": record.engine,
        "granum_version": record.granum_version,
        "case_digest": record.case_digest,
        "seconds": number(seconds),
        "case": case.resolved_toml(),
        "measures": measures(&entry),
        "presented": presented(&run),
        "notes": record.notes,
        "columns": series.as_ref().map(columns),
        "snapshots": snapshots,
        "holds": next.name,
        "next": site.without_root(next.text),
        "commands": lines,
    })))
}

/// What its report says first; null of a run that has nothing to tell yet.
fn presented(run: &Run) -> Option<Value> {
    let report = RunReport::read_without_pictures(run, RoleInStudy::Single).ok()?;
    Some(Presented::of_run(&report).to_json())
}

/// How far it is: `path`.
pub fn progress(site: &Site, query: &Query) -> Answered {
    let run = site.run(query.needed("path")?)?;
    let wrong = |error: granum_io::Error| Refused::unreadable(site.without_root(error));
    let (case, record) = (run.case().map_err(wrong)?, run.record().map_err(wrong)?);
    let end = case.test_definition().deviator_strain_end().filter(|_| record.kind != RunKind::Sample);
    Ok(Answer::Json(progress_of(&run, &record, series(&run, &record).as_ref(), end)))
}

fn series(run: &Run, record: &RunRecord) -> Option<Table> {
    if record.kind == RunKind::Test { run.series().ok() } else { None }
}

/// How far a run is; its states so far are those of `states.jsonl`.
fn progress_of(run: &Run, record: &RunRecord, series: Option<&Table>, end: Option<f64>) -> Value {
    let at_work = OutputFolder::is_in_use(run.path());
    let strain =
        series.and_then(|table| table.values("deviator_strain")?.last().copied()).filter(|_| end.is_some());
    let share = match (record.status, strain, end) {
        (RunStatus::Finished, ..) => Some(1.0),
        (_, Some(strain), Some(end)) if end > 0.0 => Some((strain / end).clamp(0.0, 1.0)),
        _ => None,
    };
    json!({
        "status": word(record, at_work),
        "at_work": at_work,
        "phase": record.phase,
        "states": series.map_or(0, Table::rows),
        "deviator_strain": strain.map(number),
        "deviator_strain_end": end.map(number),
        "share": share,
        "steps": record.steps,
    })
}

/// The measures of a run with their units, in the order of tables of runs.
fn measures(entry: &RunEntry) -> Vec<Value> {
    let table = RunsTable::from_runs(std::slice::from_ref(entry)).select(Selection::All);
    let measure = |column: &granum_core::Column| {
        let value = *column.numbers()?.first()?;
        let is_measure = !NO_MEASURES.contains(&column.name.as_str()) && !value.is_nan();
        is_measure.then(|| json!({ "name": column.name, "value": number(value), "unit": column.unit }))
    };
    table.columns().iter().filter_map(measure).collect()
}
