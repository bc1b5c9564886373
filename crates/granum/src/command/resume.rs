//! `granum resume`: go on with an interrupted run.

use std::path::PathBuf;

use clap::Args;
use granum_io::RunFolder;

use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use crate::context::Context;
use crate::failure::Failure;

/// Go on with a preparation or test that was interrupted or killed, to the same bits as if it never had been.
#[derive(Args)]
#[command(after_help = "Example:\n  granum resume run-1")]
pub struct Resume {
    /// The run folder.
    folder: PathBuf,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Resume {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let laboratory = self.hardware.laboratory(&self.checkpoints)?;
        let folder = RunFolder::open(&self.folder)?;
        let record = laboratory.resume(&folder, &mut Show::new(context))?;
        run_report::tell(context, &self.folder, &record)
    }
}
