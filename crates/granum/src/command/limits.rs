//! `granum limits`: the densest and the loosest state of the grains of a case.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_io::shell::ShowPath;
use granum_io::{QualityFlag, RunRecord, atomic::write_atomically, check_output_file};
use granum_run::laboratory::limits::{CYCLE_STRAIN, CYCLES, LOOSE_STRESS, Limits as Found};
use serde_json::{Value, json};

use super::case_flags::CaseFlags;
use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Find the void ratios e_min and e_max between which the grains of a case can be, each by a stated procedure.
///
/// Densest: compression without friction and resistance to rolling, then 20 cycles of axial strain of 1 % at constant mean stress.
/// Loosest: compression from a dispersed state with the grains' own friction and resistance to rolling at a hundredth of the mean
/// stress. Both are then at rest at the mean stress of the preparation. The two numbers are what preparation.relative_density needs.
#[derive(Args)]
#[command(after_help = "Example:\n  granum limits my-sand.toml -o limits.json")]
pub struct Limits {
    /// The case file.
    case: PathBuf,
    /// File for the result, JSON.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    flags: CaseFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Limits {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if let Some(path) = &self.output {
            check_output_file(path, context.force)?;
        }
        let case = self.flags.read(context, &self.case, false)?;
        let laboratory = self.hardware.laboratory(context, &CheckpointFlags::default())?;
        let _alone = context.nothing_written(None);
        let mut show = Show::new(context);
        let found = laboratory.limits(&case, &mut show).map_err(|error| show.failure(error))?;
        let result = as_json(&found);
        warnings(&found.records).iter().for_each(|warning| context.warn_in_json(warning));
        if let Some(path) = &self.output {
            write_atomically(path, |file| writeln!(file, "{result:#}"))?;
        }
        output::say(context, &result, || text(&found, self.output.as_deref()))
    }
}

const NAMES: [&str; 2] = ["densest", "loosest"];

fn measure(record: &RunRecord, name: &str) -> Option<f64> {
    record.measures.get(name).copied()
}

fn as_json(found: &Found) -> Value {
    let state = |record: &RunRecord, procedure: Value| {
        json!({
            "procedure": procedure,
            "solid_fraction": measure(record, "solid_fraction"),
            "coordination_number": measure(record, "coordination_number"),
            "mechanical_coordination_number": measure(record, "mechanical_coordination_number"),
            "rattler_fraction": measure(record, "rattler_fraction"),
            "mean_stress": measure(record, "mean_stress"),
            "quality": record.quality,
        })
    };
    let [dense, loose] = &found.records;
    json!({
        "densest_void_ratio": found.densest_void_ratio,
        "loosest_void_ratio": found.loosest_void_ratio,
        "densest": state(dense, json!({ "friction": 0, "cycles": CYCLES, "cycle_strain": CYCLE_STRAIN })),
        "loosest": state(
            loose,
            json!({ "friction": "own", "rolling_friction": "own", "cycles": 0, "relative_compaction_stress": LOOSE_STRESS }),
        ),
    })
}

/// The checks that a state did not pass.
fn warnings(records: &[RunRecord; 2]) -> Vec<String> {
    let of = |(name, record): (&&str, &RunRecord)| {
        let bad = record.quality.iter().filter(|flag| !flag.passed);
        let line = |flag: &QualityFlag| {
            format!("{name} state: {} is {:.3e}: {}", flag.name.replace('_', " "), flag.value, flag.advice)
        };
        bad.map(line).collect::<Vec<_>>()
    };
    NAMES.iter().zip(records).flat_map(of).collect()
}

fn text(found: &Found, output: Option<&Path>) -> String {
    let mut lines = vec![format!(
        "{:<10} {:>12} {:>16} {:>14} {:>10}",
        "state", "void ratio", "solid fraction", "coordination", "rattlers"
    )];
    let ratios = [found.densest_void_ratio, found.loosest_void_ratio];
    for ((name, record), ratio) in NAMES.iter().zip(&found.records).zip(ratios) {
        let value = |name: &str| measure(record, name).unwrap_or(f64::NAN);
        lines.push(format!(
            "{name:<10} {ratio:>12.4} {:>16.4} {:>14.3} {:>8.1} %",
            value("solid_fraction"),
            value("coordination_number"),
            100.0 * value("rattler_fraction"),
        ));
    }
    lines.extend(warnings(&found.records).iter().map(|warning| format!("warning: {warning}")));
    lines.push("for a case with a relative density:".into());
    lines.push(format!(
        "  [preparation]\n  densest_void_ratio = {:.4}\n  loosest_void_ratio = {:.4}",
        ratios[0], ratios[1]
    ));
    if let Some(path) = output {
        lines.push(format!("wrote {}", path.shown()));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_that_a_state_did_not_pass_is_a_warning() {
        let record = |value: f64| RunRecord {
            quality: vec![QualityFlag::at_most("sample_largest_overlap", value, 0.02, "lower the stress")],
            ..RunRecord::default()
        };
        let wanted = "loosest state: sample largest overlap is 3.000e-2: lower the stress";
        assert_eq!(warnings(&[record(0.01), record(0.03)]), [wanted]);
    }
}
