//! `granum prepare`: preparation of a sample.

use std::path::PathBuf;

use clap::Args;
use granum_run::laboratory::Source;
use granum_run::queue::RunKind;

use super::case_flags::CaseFlags;
use super::checkpoints::CheckpointFlags;
use super::hardware::HardwareFlags;
use super::{several_runs, single_run};
use crate::context::Context;
use crate::failure::Failure;

/// Prepare a sample: grains are placed at random without contacts, compressed isotropically, and relaxed with the final
/// properties.
///
/// Several values of a key, between commas, make several samples: all combinations, in folders below --out.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum prepare my-sand.toml --out sample\n  granum run my-sand.toml --sample sample\n  \
                  granum prepare my-sand.toml --seed 1,2,3 --out samples"
)]
pub struct Prepare {
    /// The case file.
    case: PathBuf,
    /// Folder to create: `sample` by default, or `samples` for the folders of several samples.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Use the grains of a packing file (CSV: id,x,y,z,radius) instead of placing grains at random. A loose packing is
    /// compacted as the case specifies; one that carries its load is only brought to rest.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    #[command(flatten)]
    flags: CaseFlags,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Prepare {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let cases = self.flags.read_all(context, &self.case, self.packing.is_some(), None)?;
        let laboratory = self.hardware.laboratory(context, &self.checkpoints)?;
        let source = self.packing.clone().map_or(Source::Case, Source::Packing);
        let out = |usual: &str| self.out.clone().unwrap_or_else(|| usual.into());
        match &cases[..] {
            [one] if one.name.is_empty() => {
                single_run::run(context, &laboratory, RunKind::Sample, &one.case, &source, &out("sample"))
            }
            _ => several_runs::run(context, &laboratory, RunKind::Sample, cases, &source, &out("samples")),
        }
    }
}
