//! `granum shear`: the test of a case.

use std::path::PathBuf;

use clap::Args;
use granum_hybrid::contents::{Kind, check_free};
use granum_hybrid::laboratory::Source;
use granum_io::{Case, RunFolder};

use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use crate::context::Context;
use crate::failure::Failure;

/// Make or take a sample and shear it at constant mean stress; leave a run folder.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum shear my-sand.toml --out run-1\n  granum shear my-sand.toml --sample sample --out run-2\n  \
                  granum shear my-sand.toml --packing packing.csv --out run-3"
)]
pub struct Shear {
    /// The case file.
    case: PathBuf,
    /// Folder to make.
    #[arg(short, long, default_value = "run", value_name = "DIR")]
    out: PathBuf,
    /// Take the sample that `granum prepare` left in this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "packing")]
    sample: Option<PathBuf>,
    /// Take the grains of a packing file (CSV: id,x,y,z,radius), brought to rest first.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Shear {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let case = Case::read(&self.case)?;
        let laboratory = self.hardware.laboratory(context, &self.checkpoints)?;
        let source = match (&self.sample, &self.packing) {
            (Some(folder), _) => Source::Folder(folder.clone()),
            (_, Some(file)) => Source::Packing(file.clone()),
            _ => Source::Case,
        };
        check_free(&self.out, Kind::Run, context.force)?;
        // Before there is a folder: a mistake leaves none behind, and with --force costs no older run.
        let beginning = laboratory.beginning("shear", &case, &source)?;
        let folder = RunFolder::create(&self.out, context.force)?;
        let record = laboratory.run(beginning, &folder, &mut Show::new(context))?;
        run_report::tell(context, &self.out, &record)
    }
}
