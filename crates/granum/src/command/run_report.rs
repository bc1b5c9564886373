//! The output of a command at the end of a run.

use std::path::Path;

use granum_io::run::OWN_ENGINE;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_io::{QualityFlag, RunRecord, RunSource, RunStatus};
use granum_run::remark_on_shapes;
use serde_json::{Value, json};

use super::strength_text;
use super::stresses::Stresses;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::numbers::apart;
use crate::output;

/// The phase in which a sample is prepared, in the records of runs.
const PREPARATION: &str = "prepare";

/// Prints the result of a run that ended in good order; an interruption is a failure with its own exit status.
pub fn print(context: &Context, folder: &Path, record: &RunRecord) -> Result<(), Failure> {
    if record.status == RunStatus::Interrupted {
        let left = format!(
            "the results so far are in {}; continue with `granum resume {}`",
            folder.shown(),
            quoted_path(folder)
        );
        return Err(Interrupted { left }.into());
    }
    output::say_complete(context, folder, &result(context, folder, record), || {
        format!("{}\nwrote {}", text(context, folder, record), folder.shown())
    })
}

/// Prints the result of a run that had finished earlier.
pub fn print_finished(context: &Context, folder: &Path, record: &RunRecord) -> Result<(), Failure> {
    output::say(context, &result(context, folder, record), || {
        format!("{}: it was already finished; nothing was left to do", folder.shown())
    })
}

fn result(context: &Context, folder: &Path, record: &RunRecord) -> Value {
    for flag in record.quality.iter().filter(|flag| !flag.passed) {
        context.warn_in_json(&warning(flag));
    }
    json!({
        "folder": output::path(folder),
        "status": record.status,
        "seed": record.seed,
        "engine": record.engine,
        "engine_version": record.engine_version,
        "packing": record.packing,
        "case_digest": record.case_digest,
        "measures": record.measures,
        "stresses": stresses(context, folder).map(|stresses| stresses.json()),
        "steps": record.steps,
        "wall_seconds": record.wall_seconds,
        "quality": record.quality,
        "notes": record.notes,
    })
}

/// The stresses of the test in a folder.
fn stresses(context: &Context, folder: &Path) -> Option<Stresses> {
    Stresses::read(&context.run_at(folder).ok()?)
}

/// A line about the shapes of the grains, unless all are spheres or those of a packing.
fn shapes(context: &Context, folder: &Path, record: &RunRecord) -> Option<String> {
    let case = context.run_at(folder).ok()?.case().ok()?;
    remark_on_shapes(&case).filter(|_| record.packing.is_none())
}

fn text(context: &Context, folder: &Path, record: &RunRecord) -> String {
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
    lines.extend(shapes(context, folder, record));
    if let Some(friction) = measure("preparation_friction") {
        let trials = measure("preparation_trials").unwrap_or(1.0);
        let cycles = match measure("preparation_cycles") {
            Some(cycles) if cycles > 0.0 => format!(" and {cycles} strain cycles"),
            _ => String::new(),
        };
        let stress = measure("preparation_stress").unwrap_or(0.0) / 1e3;
        let denser = match measure("preparation_densified") {
            Some(_) => ", then made denser up to the density that was asked for",
            None => "",
        };
        lines.push(format!(
            "compacted with friction {friction:.4} at {stress:.4} kPa{cycles}, after {trials} trial(s){denser}"
        ));
    }
    if let Some(steps) = record.steps.get("consolidation") {
        lines.push(format!(
            "the sample was brought to this mean stress before the test, in {steps} steps of consolidation"
        ));
    }
    if record.engine != OWN_ENGINE {
        let version = &record.engine_version;
        lines.push(format!("the test was carried out by {} {version}", record.engine));
    }
    lines.extend(stresses(context, folder).iter().flat_map(Stresses::lines));
    lines.extend(strength_text::lines(record));
    let bad: Vec<_> = record.quality.iter().filter(|q| !q.passed).collect();
    for flag in &bad {
        lines.push(format!("warning: {}", warning(flag)));
    }
    if bad.is_empty() && !record.quality.is_empty() {
        lines.push(format!("all {} quality checks passed", record.quality.len()));
    }
    lines.push(work(record));
    lines.join("\n")
}

/// The work and the time of the computation; the preparation of a sample that was taken from another folder was not part of it.
fn work(record: &RunRecord) -> String {
    let is_own = |phase: &str| phase != PREPARATION || !matches!(record.source, RunSource::Sample(_));
    let seconds = record
        .wall_seconds
        .iter()
        .filter(|(phase, _)| is_own(phase))
        .map(|(_, seconds)| seconds)
        .sum::<f64>();
    let steps =
        record.steps.iter().filter(|(phase, _)| is_own(phase)).map(|(_, steps)| *steps as f64).sum::<f64>();
    let grain_steps = steps * record.grains as f64;
    let rate = match grain_steps / seconds.max(1e-9) {
        rate @ 1e5.. => format!("{:.1} M/s", rate / 1e6),
        rate => format!("{:.0} k/s", rate / 1e3),
    };
    format!("{grain_steps:.2e} grain-steps in {seconds:.1} s ({rate})")
}

/// A readable warning for a quality flag that was not passed.
fn warning(flag: &QualityFlag) -> String {
    // The advice of this flag already contains target and value.
    if flag.name == "solid_fraction_missed_by" {
        return flag.advice.clone();
    }
    let name = flag.name.replace('_', " ");
    let [value, limit] = apart(flag.value, flag.limit);
    format!("{name} is {value} and should be at most {limit}: {}", flag.advice)
}
