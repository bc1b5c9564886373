//! The estimate of `granum campaign --dry-run`, from pilot runs in a temporary folder.

use std::path::{Path, PathBuf};
use std::time::Duration;

use granum_campaign::Campaign;
use granum_campaign::clock::readable;
use granum_campaign::execution::{CampaignEstimate, PilotOptions, pilots};
use granum_campaign::plan::{Plan, PlannedRuns};
use granum_io::Error;
use granum_run::queue::{Queue, QueueError};
use serde_json::{Value, json};

use super::flags::PlanFlags;
use super::scheduling;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::messages;

/// A folder that is removed with all that it holds.
struct Temporary(PathBuf);

impl Temporary {
    fn new() -> Result<Temporary, Failure> {
        let path = std::env::temp_dir().join(format!("granum-pilots-{}", std::process::id()));
        // An existing one is not taken over: it is somebody else's.
        std::fs::create_dir(&path).map_err(Error::file("create the folder", &path))?;
        Ok(Temporary(path))
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // What cannot be removed is left to the system, which clears this place.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Makes the pilot runs; `None` if none are asked for.
pub fn run_pilots(
    context: &Context,
    flags: &PlanFlags,
    plan: &Plan,
    planned: &PlannedRuns,
) -> Result<Option<CampaignEstimate>, Failure> {
    if flags.pilots == 0 {
        return Ok(None);
    }
    let folder = Temporary::new()?;
    let campaign = Campaign::new(folder.path(), plan, planned, env!("CARGO_PKG_VERSION"));
    let laboratory = campaign.laboratory(&flags.carry_out.laboratory(context)?);
    let executor = scheduling::executor(context, folder.path(), &flags.carry_out)?;
    let workers = match flags.carry_out.workers()? {
        Some(count) => count,
        None => Queue::new(campaign.all_queued()?)?.at_once(laboratory.resources.hardware.threads),
    };
    if !context.json {
        let count = flags.pilots.min(planned.runs.len());
        messages::line(format_args!("{count} pilot runs of at most {} each", readable(flags.pilot_time)));
    }
    let options = PilotOptions {
        count: flags.pilots,
        longest: flags.pilot_time,
        workers: workers.min(planned.runs.len()),
    };
    let flow = || context.flow();
    let found = pilots(&campaign, folder.path(), &laboratory, &executor, options, &flow);
    let found = found.map_err(|error| match error {
        QueueError::File(error) => Failure::from(error),
        other => other.into(),
    })?;
    if context.stopped() {
        return Err(Interrupted { left: "nothing was written".into() }.into());
    }
    if found.is_none() {
        context.warn("no pilot run came far enough for an estimate; give them more time with --pilot-time");
    }
    Ok(found)
}

/// The estimate in words.
pub fn text(found: &CampaignEstimate) -> String {
    let time = |seconds: f64| readable(Duration::from_secs_f64(seconds.clamp(0.0, 1e12)));
    let mut lines = Vec::new();
    if !found.pilots.is_empty() {
        let [low, high] = found.between;
        lines.push(format!(
            "estimate from {} pilot runs: {} with {} runs at once (from {} by the fastest pilot to {} by the slowest)",
            found.pilots.len(),
            time(found.seconds),
            found.workers,
            time(low),
            time(high)
        ));
        let memory = found.memory.map(|bytes| format!("{} of memory for each run, ", size(bytes as f64)));
        let at_least = if found.unfinished() > 0 { "at least " } else { "" };
        lines.push(format!("  {}{at_least}{} of disk", memory.unwrap_or_default(), size(found.disk)));
        if found.unfinished() > 0 {
            lines.push(format!(
                "  {} pilots were not finished and are judged by the part that they did; longer ones: --pilot-time",
                found.unfinished()
            ));
        }
        if found.pilots.iter().any(|pilot| !pilot.in_test) {
            lines.push("  a pilot did not reach its test, so that the time is uncertain".into());
        }
    }
    lines.extend(found.failed.iter().map(|(name, why)| format!("the pilot {name} failed: {why}")));
    lines.join("\n")
}

/// A number of bytes with a unit.
fn size(bytes: f64) -> String {
    match bytes {
        1e9.. => format!("{:.1} GB", bytes / 1e9),
        1e6.. => format!("{:.0} MB", bytes / 1e6),
        _ => format!("{:.0} kB", bytes / 1e3),
    }
}

/// The estimate as JSON.
pub fn as_json(found: &CampaignEstimate) -> Value {
    let pilot = |pilot: &granum_campaign::execution::Pilot| {
        json!({
            "name": pilot.name, "seconds": pilot.seconds, "finished": pilot.finished, "in_test": pilot.in_test,
            "memory_bytes": pilot.memory, "disk_bytes": pilot.disk,
        })
    };
    json!({
        "workers": found.workers,
        "seconds": found.seconds,
        "seconds_between": found.between,
        "memory_bytes": found.memory,
        "disk_bytes": found.disk,
        "pilots": found.pilots.iter().map(pilot).collect::<Vec<_>>(),
        "failed": found.failed.iter().map(|(name, why)| json!({ "name": name, "reason": why })).collect::<Vec<_>>(),
    })
}
