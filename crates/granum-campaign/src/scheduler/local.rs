//! The runs of a campaign on this machine, each in a process of its own.

use std::path::Path;

use granum_io::{Error, OutputFolder};
use granum_run::Flow;

use super::scheduler_error::SchedulerError;
use super::scheduler_trait::{Order, Scheduler, SchedulerKind, SchedulerOptions, Submitted};
use crate::campaign::Campaign;
use crate::claim::is_claimed;
use crate::data_set::{self, Collected};
use crate::execution::{CAMPAIGN_CLAIM, CampaignObserver, ChildProcesses, Coordinator, STOP_REQUEST};
use crate::jobs::{Jobs, Place};

/// Its entry in the registry.
pub(super) const KIND: SchedulerKind = SchedulerKind {
    name: "local",
    help: "here, each run in a process of its own; the command ends when they have ended",
    make: |options| Box::new(Local(options)),
};

/// Executes runs here.
struct Local(SchedulerOptions);

impl Scheduler for Local {
    fn submit(
        &self,
        order: &Order<'_>,
        observer: &dyn CampaignObserver,
    ) -> Result<Submitted, SchedulerError> {
        let executor =
            ChildProcesses::new(self.0.program.clone(), order.campaign.folder(), self.0.arguments.clone());
        let coordinator = Coordinator {
            campaign: order.campaign,
            laboratory: order.laboratory,
            executor: &executor,
            workers: self.0.workers,
            stop_after: self.0.stop_after,
            again: order.again,
        };
        Ok(Submitted::Ended(coordinator.run(order.folder, order.replace_others, observer)?))
    }

    fn poll(&self, campaign: &Campaign) -> Result<Jobs, SchedulerError> {
        let is_running = |name: &str| OutputFolder::is_in_use(campaign.folder_of(name));
        let running = campaign.runs().iter().filter(|run| is_running(&run.name));
        Ok(Jobs { places: running.map(|run| (run.name.clone(), Place::Running)).collect(), jobs: Vec::new() })
    }

    /// Asks the coordinator by a file, on whatever machine it is.
    fn cancel(&self, campaign: &Campaign) -> Result<usize, SchedulerError> {
        let is_at_work =
            OutputFolder::is_in_use(campaign.folder()) || is_claimed(campaign.folder(), CAMPAIGN_CLAIM);
        if !is_at_work {
            return Ok(0);
        }
        request(campaign.folder())?;
        Ok(1)
    }

    fn collect(
        &self,
        campaign: &Campaign,
        flow: &(dyn Fn() -> Flow + Sync),
    ) -> Result<Collected, SchedulerError> {
        Ok(data_set::collect(campaign, flow)?)
    }
}

fn request(folder: &Path) -> Result<(), Error> {
    let path = folder.join(STOP_REQUEST);
    std::fs::write(&path, "").map_err(Error::file("write", &path))
}
