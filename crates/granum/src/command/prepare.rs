//! `granum prepare`: make a sample.

use std::path::PathBuf;

use clap::Args;
use granum_hybrid::laboratory::{Source, memory};
use granum_io::{Case, RunFolder};

use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use crate::context::Context;
use crate::failure::Failure;

/// Make a sample: grains placed at random from a seed so that none touch, compressed isotropically, and relaxed with the final
/// properties.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum prepare my-sand.toml --out sample\n  granum shear my-sand.toml --sample sample"
)]
pub struct Prepare {
    /// The case file.
    case: PathBuf,
    /// Folder to make.
    #[arg(short, long, default_value = "sample", value_name = "DIR")]
    out: PathBuf,
    /// Take the grains of a packing file (CSV: id,x,y,z,radius) instead of placing grains at random.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Prepare {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let case = Case::read(&self.case)?;
        let laboratory = self.hardware.laboratory(&self.checkpoints)?;
        let source = self.packing.clone().map_or(Source::Case, Source::Packing);
        if source == Source::Case {
            memory::check(&case)?;
        }
        let folder = RunFolder::create(&self.out, context.force)?;
        let record = laboratory.prepare(&case, &source, &folder, &mut Show::new(context))?;
        run_report::tell(context, &self.out, &record)
    }
}
