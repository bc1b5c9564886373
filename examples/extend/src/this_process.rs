//! A scheduler of campaigns: it executes the runs in this process, by the threads of the laboratory, and none is started for them.

use granum::campaign::Campaign;
use granum::campaign::data_set::{self, Collected};
use granum::campaign::execution::{CampaignObserver, Coordinator};
use granum::campaign::scheduler::{
    Jobs, Order, Scheduler, SchedulerError, SchedulerKind, SchedulerOptions, Submitted,
};
use granum::run::Flow;
use granum::run::queue::InThisProcess;

/// Its entry in a registry.
pub const THIS_PROCESS: SchedulerKind = SchedulerKind {
    name: "this-process",
    help: "here, all runs in one process; the command ends when they have ended",
    make: |options| Box::new(ThisProcess(options)),
};

struct ThisProcess(SchedulerOptions);

impl Scheduler for ThisProcess {
    fn submit(
        &self,
        order: &Order<'_>,
        observer: &dyn CampaignObserver,
    ) -> Result<Submitted, SchedulerError> {
        let coordinator = Coordinator {
            campaign: order.campaign,
            laboratory: order.laboratory,
            executor: &InThisProcess(order.laboratory),
            workers: self.0.workers,
            stop_after: self.0.stop_after,
            again: order.again,
        };
        Ok(Submitted::Ended(coordinator.run(order.folder, order.replace_others, observer)?))
    }

    fn poll(&self, _: &Campaign) -> Result<Jobs, SchedulerError> {
        Ok(Jobs::default())
    }

    /// What goes on ends with the process, by Ctrl-C.
    fn cancel(&self, _: &Campaign) -> Result<usize, SchedulerError> {
        Ok(0)
    }

    fn collect(
        &self,
        campaign: &Campaign,
        flow: &(dyn Fn() -> Flow + Sync),
    ) -> Result<Collected, SchedulerError> {
        Ok(data_set::collect(campaign, flow)?)
    }
}
