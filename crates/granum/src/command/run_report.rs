//! The output of a command at the end of a run.

use std::path::Path;

use granum_io::shell::quoted_path;
use granum_io::{QualityFlag, RunRecord, RunStatus};
use serde_json::{Value, json};

use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// Prints the result of a run that ended in good order; an interruption is a failure with its own exit status.
pub fn print(context: &Context, folder: &Path, record: &RunRecord) -> Result<(), Failure> {
    if record.status == RunStatus::Interrupted {
        let left = format!(
            "the results so far are in {}; continue with `granum resume {}`",
            folder.display(),
            quoted_path(folder)
        );
        return Err(Interrupted { left }.into());
    }
    output::say_complete(context, folder, &result(context, folder, record), || {
        format!("{}\nwrote {}", text(record), folder.display())
    })
}

/// Prints the result of a run that had finished earlier.
pub fn print_finished(context: &Context, folder: &Path, record: &RunRecord) -> Result<(), Failure> {
    output::say(context, &result(context, folder, record), || {
        format!("{}: it was already finished; nothing was left to do", folder.display())
    })
}

fn result(context: &Context, folder: &Path, record: &RunRecord) -> Value {
    for flag in record.quality.iter().filter(|flag| !flag.passed) {
        context.warn_in_json(&warning(flag));
    }
    json!({
        "folder": folder,
        "status": record.status,
        "seed": record.seed,
        "packing": record.packing,
        "case_digest": record.case_digest,
        "measures": record.measures,
        "steps": record.steps,
        "wall_seconds": record.wall_seconds,
        "quality": record.quality,
        "notes": record.notes,
    })
}

fn text(record: &RunRecord) -> String {
    let mut lines = Vec::new();
    let measure = |name: &str| record.measures.get(name).copied();
    if let Some(solid_fraction) = measure("solid_fraction") {
        let value = |name: &str| measure(name).map_or("-".to_string(), |v| format!("{v:.3}"));
        let packing = record.packing.as_ref().map_or(String::new(), |p| format!(" of {}", p.file_name));
        lines.push(format!(
            "sample: {} grains{packing}, solid fraction {solid_fraction:.4}, coordination number {} (all grains), {} \
             (mechanical: grains with two or more contacts), rattlers {:.1} %, p {:.2} kPa",
            record.grains,
            value("coordination_number"),
            value("mechanical_coordination_number"),
            100.0 * measure("rattler_fraction").unwrap_or(0.0),
            measure("mean_stress").unwrap_or(0.0) / 1e3,
        ));
    }
    if let Some(friction) = measure("preparation_friction") {
        let trials = measure("preparation_trials").unwrap_or(1.0);
        let cycles = match measure("preparation_cycles") {
            Some(cycles) if cycles > 0.0 => format!(" and {cycles} strain cycles"),
            _ => String::new(),
        };
        let stress = measure("preparation_stress").unwrap_or(0.0) / 1e3;
        lines.push(format!(
            "compacted with friction {friction:.4} at {stress:.4} kPa{cycles}, after {trials} trial(s)"
        ));
    }
    if let Some(steps) = record.steps.get("consolidation") {
        lines.push(format!(
            "the sample was brought to this mean stress before the test, in {steps} steps of consolidation"
        ));
    }
    lines.extend(peak_and_late(record));
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
    lines.join("\n")
}

/// Peak and late values of a finished test.
fn peak_and_late(record: &RunRecord) -> Option<String> {
    let value = |name: &str| record.measures.get(name).copied();
    let peak = value("peak_stress_ratio")?;
    // The measures of a test that is defined as a list of stages use the invariants.
    let (strain, at) = match (value("deviator_strain_at_peak"), value("deviatoric_strain_at_peak")) {
        (Some(at), _) => ("deviator", at),
        (None, at) => ("deviatoric", at?),
    };
    Some(format!(
        "test: peak q/p {peak:.3} at {strain} strain {at:.4}; means over the last quarter of the strain: q/p {:.3}, phi_d {:.4}, solid \
         fraction {:.4}",
        value("late_stress_ratio")?,
        value("late_deviator_fabric")?,
        value("late_solid_fraction")?,
    ))
}

/// A readable warning for a quality flag that was not passed.
fn warning(flag: &QualityFlag) -> String {
    // The advice of this flag already contains target and value.
    if flag.name == "solid_fraction_missed_by" {
        return flag.advice.clone();
    }
    let name = flag.name.replace('_', " ");
    format!("{name} is {:.3e} and should be at most {:.1e}: {}", flag.value, flag.limit, flag.advice)
}
