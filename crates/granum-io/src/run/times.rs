//! `seconds.json`: what depends on the computer and on interruptions and not on the case, so that all other files of a run
//! have the same bytes on every computer.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::record::{Machine, RunRecord, phases_of_any_version};
use crate::error::Result;
use crate::sealed::{unseal, write_sealed};

/// File of the wall times of a run.
pub(super) const TIMES: &str = "seconds.json";

/// The content of the file.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Times {
    #[serde(default)]
    machine: Machine,
    /// Seconds of wall time by phase.
    #[serde(default, deserialize_with = "phases_of_any_version")]
    wall_seconds: BTreeMap<String, f64>,
}

/// Writes the times of a record.
pub(super) fn write(folder: &Path, record: &RunRecord) -> Result<()> {
    let times = Times { machine: record.machine.clone(), wall_seconds: record.wall_seconds.clone() };
    write_sealed(&folder.join(TIMES), &times)
}

/// Adds the times to a record. Those of earlier versions are in the record itself. No result depends on times: where the file
/// is missing or damaged the times are unknown.
pub(super) fn read_into(folder: &Path, record: &mut RunRecord) {
    if let Some(times) = read(&folder.join(TIMES)) {
        (record.machine, record.wall_seconds) = (times.machine, times.wall_seconds);
    }
}

fn read(path: &Path) -> Option<Times> {
    let text = crate::text::read_small(path, 1 << 20).ok()?;
    serde_json::from_str(&unseal(path, &text).ok()?.text).ok()
}
