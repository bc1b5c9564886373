//! What a list tells of each thing, from its record alone.

use std::time::UNIX_EPOCH;

use granum_io::{OutputFolder, Run, RunKind, RunRecord, RunStatus};
use serde_json::{Map, Value, json};

use super::found::{Found, Kind};
use crate::numbers::number;

/// Measures of a test that a list shows, of which the first that is known stands.
const SHOWN: [(&str, &str, &str); 4] = [
    ("peak_friction_angle", "peak friction angle", "deg"),
    ("peak_stress_ratio", "peak q/p", ""),
    ("peak_von_mises_ratio", "peak q/p", ""),
    ("solid_fraction", "solid fraction", ""),
];

/// What a list tells of something, by name. Of what may not be read it tells its kind alone.
pub(crate) fn told(found: &Found, is_readable: bool) -> Map<String, Value> {
    let seconds = found.modified.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    let mut about = Map::from_iter([
        ("kind".to_string(), json!(found.kind.word())),
        ("modified".to_string(), seconds.map_or(Value::Null, |since| json!(since.as_secs()))),
    ]);
    match found.kind {
        _ if !is_readable => {
            about.insert("status".into(), json!("damaged"));
        }
        Kind::Run => about.extend(of_run(found)),
        Kind::Campaign | Kind::Study if OutputFolder::is_in_use(&found.place) => {
            about.insert("status".into(), json!("running"));
        }
        _ => {}
    }
    about
}

fn of_run(found: &Found) -> Map<String, Value> {
    let record = match Run::at(&found.place).and_then(|run| run.record()) {
        Ok(record) => record,
        Err(_) => return Map::from_iter([("status".into(), json!("damaged"))]),
    };
    let measure = SHOWN.iter().find_map(|(key, name, unit)| {
        let value = record.measures.get(*key).filter(|value| value.is_finite())?;
        Some(json!({ "name": name, "value": number(*value), "unit": unit }))
    });
    Map::from_iter([
        ("status".into(), json!(word(&record, OutputFolder::is_in_use(&found.place)))),
        ("what".into(), json!(if record.kind == RunKind::Sample { "sample" } else { "test" })),
        ("grains".into(), json!(record.grains)),
        ("phase".into(), json!(record.phase)),
        ("measure".into(), measure.unwrap_or_default()),
        ("checks_failed".into(), json!(record.quality.iter().filter(|check| !check.passed).count())),
    ])
}

/// A word for the status; a run that is recorded as running, but on which no process works, was killed.
pub(crate) fn word(record: &RunRecord, at_work: bool) -> &'static str {
    match record.status {
        _ if at_work => "running",
        RunStatus::Running => "killed",
        RunStatus::Interrupted => "interrupted",
        RunStatus::Finished => "finished",
        RunStatus::Failed => "failed",
    }
}
