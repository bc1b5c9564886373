//! What a command that ran something tells at its end.

use std::path::Path;

use granum_io::{QualityFlag, RunRecord, RunStatus};
use serde_json::json;

use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// Tells of a run that ended in good order; an interruption is a failure with its own status.
pub fn tell(context: &Context, folder: &Path, record: &RunRecord) -> Result<(), Failure> {
    if record.status == RunStatus::Interrupted {
        let left = format!("what was done is in {0}; go on with `granum resume {0}`", folder.display());
        return Err(Interrupted { left }.into());
    }
    let result = json!({
        "folder": folder,
        "status": record.status,
        "measures": record.measures,
        "steps": record.steps,
        "wall_seconds": record.wall_seconds,
        "quality": record.quality,
    });
    output::say(context, &result, || text(folder, record))
}

fn text(folder: &Path, record: &RunRecord) -> String {
    let mut lines = Vec::new();
    let measure = |name: &str| record.measures.get(name).copied();
    if let Some(solid_fraction) = measure("solid_fraction") {
        let value = |name: &str| measure(name).map_or("-".to_string(), |v| format!("{v:.3}"));
        lines.push(format!(
            "sample: {} grains, solid fraction {solid_fraction:.4}, coordination number {} (all grains), {} (grains with two \
             contacts or more), rattlers {:.1} %, p {:.2} kPa",
            record.grains,
            value("coordination_number"),
            value("backbone_coordination_number"),
            100.0 * measure("rattler_fraction").unwrap_or(0.0),
            measure("mean_stress").unwrap_or(0.0) / 1e3,
        ));
    }
    if let Some(friction) = measure("preparation_friction") {
        lines.push(format!(
            "preparation friction {friction:.4} after {} trial(s)",
            measure("preparation_trials").unwrap_or(1.0)
        ));
    }
    let bad: Vec<_> = record.quality.iter().filter(|q| !q.passed).collect();
    for flag in &bad {
        lines.push(format!("warning: {}", warning(flag)));
    }
    if bad.is_empty() && !record.quality.is_empty() {
        lines.push(format!("all {} quality checks passed", record.quality.len()));
    }
    let seconds: f64 = record.wall_seconds.values().sum();
    let rate = record.grain_steps() as f64 / seconds.max(1e-9) / 1e6;
    lines.push(format!("{:.2e} grain-steps in {seconds:.1} s ({rate:.1} M/s)", record.grain_steps() as f64));
    lines.push(format!("wrote {}", folder.display()));
    lines.join("\n")
}

/// A judgement that is not good, for people.
fn warning(flag: &QualityFlag) -> String {
    // Its advice says target and value.
    if flag.name == "solid_fraction_missed_by" {
        return flag.advice.clone();
    }
    let name = flag.name.replace('_', " ");
    format!("{name} is {:.3e} and should be at most {:.1e}: {}", flag.value, flag.limit, flag.advice)
}
