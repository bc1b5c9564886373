//! `granum prepare`: preparation of a sample.

use std::path::PathBuf;

use clap::Args;
use granum::contents::{Kind, check_free};
use granum_io::RunFolder;
use granum_run::laboratory::Source;

use super::case_flags::CaseFlags;
use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use crate::context::Context;
use crate::failure::Failure;

/// Prepare a sample: grains are placed at random without contacts, compressed isotropically, and relaxed with the final
/// properties.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum prepare my-sand.toml --out sample\n  granum shear my-sand.toml --sample sample"
)]
pub struct Prepare {
    /// The case file.
    case: PathBuf,
    /// Folder to create.
    #[arg(short, long, default_value = "sample", value_name = "DIR")]
    out: PathBuf,
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
        let case = self.flags.read(&self.case, self.packing.is_some())?;
        let laboratory = self.hardware.laboratory(context, &self.checkpoints)?;
        let source = self.packing.clone().map_or(Source::Case, Source::Packing);
        check_free(&self.out, Kind::Run, context.force)?;
        // Inputs are checked before the folder is created, so that a mistake leaves no folder behind and, with --force, does
        // not delete an older run.
        let mut show = Show::new(context);
        let planned = laboratory.planned("prepare", &case, &source, &mut show)?;
        let folder = RunFolder::create(&self.out, context.force)?;
        let record = planned.run(&folder, &mut show)?;
        run_report::print(context, &self.out, &record)
    }
}
