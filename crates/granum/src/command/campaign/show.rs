//! The progress of a campaign on the terminal.

use std::sync::{Mutex, PoisonError};

use granum_campaign::execution::{CampaignObserver, CampaignProgress};
use granum_run::Flow;
use granum_run::laboratory::ProgressField;

use crate::context::Context;
use crate::progress::Progress;

/// Shows the progress in one line, and stops the campaign when the user asks for it.
pub struct ShowCampaign<'a> {
    context: &'a Context,
    shown: Mutex<Progress>,
}

impl<'a> ShowCampaign<'a> {
    pub fn new(context: &'a Context) -> ShowCampaign<'a> {
        let mut progress = context.progress();
        progress.phase("campaign");
        ShowCampaign { context, shown: Mutex::new(progress) }
    }
}

impl CampaignObserver for ShowCampaign<'_> {
    fn progress(&self, progress: &CampaignProgress) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.update(Some(progress.share), |_| {
            let mut fields =
                vec![ProgressField::new(0, format!("{} of {} runs", progress.finished, progress.runs))];
            let some = |count: usize, what: &str| {
                (count > 0).then(|| ProgressField::new(1, format!("{count} {what}")))
            };
            fields.extend(some(progress.failed, "failed"));
            fields.extend(some(progress.flagged, "flagged"));
            fields.extend(
                progress.runs_per_hour.map(|rate| ProgressField::new(2, format!("{rate:.0} runs/h"))),
            );
            fields
        });
    }

    fn warn(&self, text: &str) {
        // Held, so that the line of progress is not written in between.
        let shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.aside(|| self.context.warn(text));
    }

    fn flow(&self) -> Flow {
        self.context.flow()
    }
}
