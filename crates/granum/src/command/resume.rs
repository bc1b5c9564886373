//! `granum resume`: go on with an interrupted run.

use std::path::PathBuf;

use clap::Args;
use granum_hybrid::files::STUDY_FILE;
use granum_io::RunFolder;
use serde_json::json;

use super::checkpoints::CheckpointFlags;
use super::hardware::{HardwareFlags, Show};
use super::run_report;
use super::train::Train;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Continue a preparation, test or training that was interrupted or killed; it ends with exactly the results that it would have
/// had without the interruption.
#[derive(Args)]
#[command(after_help = "Example:\n  granum resume run-1")]
pub struct Resume {
    /// The run folder, or the folder of a training.
    folder: PathBuf,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Resume {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if Train::is_in(&self.folder) {
            return self.training(context);
        }
        let laboratory = self.hardware.laboratory(&self.checkpoints)?;
        let folder = RunFolder::open(&self.folder)?;
        let record = laboratory.resume(&folder, &mut Show::new(context))?;
        run_report::tell(context, &self.folder, &record)
    }

    /// Goes on with a training.
    fn training(&self, context: &Context) -> Result<(), Failure> {
        let name = self.folder.display();
        if self.folder.join(STUDY_FILE).is_file() {
            let result = json!({ "study": self.folder, "status": "finished" });
            return output::say(context, &result, || format!("{name}: the training is finished"));
        }
        // What is there is gone on with; nothing is to be replaced.
        let context = context.without_force();
        Train::resumed(&self.folder, self.hardware.threads, self.checkpoints.clone())?.run(&context)
    }
}
