//! The common part of `granum shear` and `granum run`: the source of the sample, the output folder and the run itself.

use std::path::PathBuf;

use clap::Args;
use granum::contents::{Kind, check_free};
use granum_io::{Case, RunFolder};
use granum_run::laboratory::Source;

use super::case_flags::CaseFlags;
use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use crate::context::Context;
use crate::failure::Failure;

#[derive(Args)]
pub struct TestRun {
    /// Folder to create.
    #[arg(short, long, default_value = "run", value_name = "DIR")]
    out: PathBuf,
    /// Use the sample that `granum prepare` wrote to this folder.
    #[arg(long, value_name = "DIR", conflicts_with = "packing")]
    sample: Option<PathBuf>,
    /// Use the grains of a packing file (CSV: id,x,y,z,radius). A loose packing is compacted as the case specifies; one that
    /// carries its load is only brought to rest.
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
    /// True if the sample is made from a packing.
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
        // Inputs are checked before the folder is created, so that a mistake leaves no folder behind and, with --force, does
        // not delete an older run.
        let mut show = Show::new(context);
        let planned = laboratory.planned("shear", case, &source, &mut show)?;
        let folder = RunFolder::create(&self.out, context.force)?;
        let record = planned.run(&folder, &mut show)?;
        run_report::print(context, &self.out, &record)
    }
}
