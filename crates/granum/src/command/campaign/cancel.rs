//! `granum campaign cancel`: ends what is queued and what goes on.

use std::path::PathBuf;

use clap::Args;
use granum_campaign::scheduler::SchedulerOptions;
use granum_io::shell::{ShowPath, quoted_path};
use serde_json::json;

use super::folder::campaign_in;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// End all runs of a campaign that are queued or go on, on this or another machine. What goes on writes a checkpoint first, and the same
/// command as before goes on from there.
#[derive(Args)]
#[command(after_help = "Example:\n  granum campaign cancel study")]
pub struct Cancel {
    /// Folder of the campaign.
    folder: PathBuf,
}

impl Cancel {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let name = self.folder.shown();
        let campaign = campaign_in(context, &self.folder)?;
        let mut count = 0;
        for kind in context.schedulers().all() {
            count += (kind.make)(SchedulerOptions::default()).cancel(&campaign)?;
        }
        let result = json!({ "folder": output::path(&self.folder), "cancelled": count });
        output::say(context, &result, || match count {
            0 => format!("{name}: nothing is queued or goes on"),
            _ => format!(
                "{name}: what is queued or goes on was asked to end; see `granum campaign status {}`",
                quoted_path(&self.folder)
            ),
        })
    }
}
