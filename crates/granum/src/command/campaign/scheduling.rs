//! The scheduler of a campaign, from the flags of the command.

use granum_campaign::Campaign;
use granum_campaign::execution::ChildProcesses;
use granum_campaign::scheduler::{self, Jobs, Scheduler, SchedulerOptions};
use granum_io::Error;
use granum_io::shell::quoted_path;

use super::flags::{CarryOutFlags, SchedulerFlags};
use crate::context::Context;
use crate::failure::Failure;

/// Longest header of a script.
const LONGEST_HEADER: u64 = 1 << 20;

impl CarryOutFlags {
    /// What a scheduler needs to execute runs by this program.
    pub fn options(&self, context: &Context) -> Result<SchedulerOptions, Failure> {
        Ok(SchedulerOptions {
            program: context.program()?,
            arguments: self.arguments(context)?,
            workers: self.workers()?,
            stop_after: self.stop_after,
            ..SchedulerOptions::default()
        })
    }
}

impl SchedulerFlags {
    /// The scheduler of this machine.
    pub fn local() -> SchedulerFlags {
        SchedulerFlags {
            scheduler: scheduler::DEFAULT.into(),
            time: None,
            per_task: None,
            partition: None,
            account: None,
            header: None,
        }
    }

    pub fn is_local(&self) -> bool {
        self.scheduler == scheduler::DEFAULT
    }

    /// Refuses flags that do not belong together.
    pub fn check(&self, carry_out: &CarryOutFlags) -> Result<(), Failure> {
        let given = [
            ("--time", self.time.is_some()),
            ("--per-task", self.per_task.is_some()),
            ("--partition", self.partition.is_some()),
            ("--account", self.account.is_some()),
            ("--header", self.header.is_some()),
        ];
        let first = given.iter().find(|(_, is_given)| *is_given);
        match (self.is_local(), first) {
            (true, Some((flag, _))) => Err(Failure::new(format!(
                "{flag} belongs to a cluster; name its scheduler: --scheduler slurm"
            ))),
            (false, _) if carry_out.stop_after.is_some() => {
                Err(Failure::new("--stop-after is for runs on this machine; a job has its --time"))
            }
            _ => Ok(()),
        }
    }

    /// The scheduler, which can be asked from this machine.
    pub fn scheduler(
        &self,
        context: &Context,
        carry_out: &CarryOutFlags,
    ) -> Result<Box<dyn Scheduler>, Failure> {
        let header = self.header.as_ref().map(|file| {
            granum_core::input::read_text(file, LONGEST_HEADER).map_err(Error::file("read", file))
        });
        let options = SchedulerOptions {
            time: self.time,
            per_task: self.per_task.map(|count| count as usize),
            partition: self.partition.clone(),
            account: self.account.clone(),
            header: header
                .transpose()?
                .map(|text| if text.is_empty() || text.ends_with('\n') { text } else { text + "\n" }),
            ..carry_out.options(context)?
        };
        let scheduler = context.schedulers().named(&self.scheduler, options)?;
        scheduler.check()?;
        Ok(scheduler)
    }
}

/// Refuses to execute runs here that another scheduler still has.
pub fn check_none_queued(context: &Context, campaign: &Campaign) -> Result<(), Failure> {
    let waiting: usize = match context.schedulers().poll(campaign) {
        Ok(jobs) => jobs.jobs.iter().map(|job| job.queued + job.running).sum(),
        Err(error) => {
            context.warn(&format!("it is not known whether jobs of this campaign go on: {error}"));
            0
        }
    };
    if waiting == 0 {
        return Ok(());
    }
    let name = quoted_path(campaign.folder());
    Err(Failure::new(format!(
        "{waiting} elements of jobs of this campaign are queued or go on; see `granum campaign status {name}`, end them with `granum \
         campaign cancel {name}`, or submit what is left with --scheduler slurm"
    )))
}

/// Where the runs of a campaign are that a scheduler has; without an answer a warning.
pub fn jobs(context: &Context, campaign: &Campaign) -> Jobs {
    context.schedulers().poll(campaign).unwrap_or_else(|error| {
        context.warn(&format!(
            "the scheduler cannot be asked, so that only the folders of the runs are known: {error}"
        ));
        Jobs::default()
    })
}

/// Executes the runs of a campaign by this program, for elements and pilots.
pub fn executor(
    context: &Context,
    campaign: &std::path::Path,
    flags: &CarryOutFlags,
) -> Result<ChildProcesses, Failure> {
    let options = flags.options(context)?;
    Ok(ChildProcesses::new(options.program, campaign, options.arguments))
}
