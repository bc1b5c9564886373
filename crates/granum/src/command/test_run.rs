//! What `granum shear` and `granum run` share: where the sample comes from, where the run goes, and running it.

use std::path::PathBuf;

use clap::Args;
use granum_io::{Case, RunFolder};
use granum_learn::contents::{Kind, check_free};
use granum_run::laboratory::Source;

use super::case_flags::CaseFlags;
use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use crate::context::Context;
use crate::failure::Failure;

#[derive(Args)]
pub struct TestRun {
    /// Folder to make.
    #[arg(short, long, default_value = "run", value_name = "DIR")]
    out: PathBuf,
    /// Take the sample that `granum prepare` left in this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "packing")]
    sample: Option<PathBuf>,
    /// Take the grains of a packing file (CSV: id,x,y,z,radius): a loose one is compacted as the case says, one that carries
    /// its load only comes to rest.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    #[command(flatten)]
    pub flags: CaseFlags,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl TestRun {
    /// True if the sample is made of a packing.
    pub fn has_packing(&self) -> bool {
        self.packing.is_some()
    }

    /// Runs the test of a case.
    pub fn run(&self, context: &Context, case: &Case) -> Result<(), Failure> {
        let laboratory = self.hardware.laboratory(context, &self.checkpoints)?;
        let source = match (&self.sample, &self.packing) {
            (Some(folder), _) => Source::Folder(folder.clone()),
            (_, Some(file)) => Source::Packing(file.clone()),
            _ => Source::Case,
        };
        check_free(&self.out, Kind::Run, context.force)?;
        // Before there is a folder: a mistake leaves none behind, and with --force costs no older run.
        let mut show = Show::new(context);
        let planned = laboratory.planned("shear", case, &source, &mut show)?;
        let folder = RunFolder::create(&self.out, context.force)?;
        let record = planned.run(&folder, &mut show)?;
        run_report::print(context, &self.out, &record)
    }
}
