//! `granum limits`: the densest and the loosest state of the grains of a case.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_io::{RunRecord, atomic::write_atomically, check_output_file};
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
        let case = self.flags.read(&self.case, false)?;
        let laboratory = self.hardware.laboratory(context, &CheckpointFlags::default())?;
        let found = laboratory.limits(&case, &mut Show::new(context))?;
        let result = as_json(&found);
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
        for flag in record.quality.iter().filter(|flag| !flag.passed) {
            lines.push(format!(
                "warning, {name}: {} is {:.3e}: {}",
                flag.name.replace('_', " "),
                flag.value,
                flag.advice
            ));
        }
    }
    lines.push("for a case with a relative density:".into());
    lines.push(format!(
        "  [preparation]\n  densest_void_ratio = {:.4}\n  loosest_void_ratio = {:.4}",
        ratios[0], ratios[1]
    ));
    if let Some(path) = output {
        lines.push(format!("wrote {}", path.display()));
    }
    lines.join("\n")
}
