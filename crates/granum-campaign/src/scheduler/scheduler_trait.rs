//! What a scheduler is.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use granum_io::OutputFolder;
use granum_run::{Flow, Laboratory};

use super::scheduler_error::SchedulerError;
use crate::campaign::Campaign;
use crate::data_set::Collected;
use crate::execution::{CampaignObserver, Summary};
use crate::jobs::Jobs;

/// Executes the runs of a campaign: here, or somewhere that sees the folder of the campaign. What it does is told by the folders of the
/// runs, so that a program may end and another one ask later.
pub trait Scheduler: Send + Sync {
    /// Refuses a machine from which it cannot be asked, before anything is prepared for it.
    ///
    /// # Errors
    /// [`SchedulerError`] that says what is missing.
    fn check(&self) -> Result<(), SchedulerError> {
        Ok(())
    }

    /// True if it packs several runs into one job, for which it needs to know how long runs take ([`Order::pace`]).
    fn packs(&self) -> bool {
        false
    }

    /// Gives it all runs that are neither finished nor already given to it. A scheduler that executes runs itself returns when they have
    /// ended; one that queues them returns at once.
    ///
    /// # Errors
    /// [`SchedulerError`] if they cannot be given to it. Runs that fail are told by their state.
    fn submit(&self, order: &Order<'_>, observer: &dyn CampaignObserver)
    -> Result<Submitted, SchedulerError>;

    /// Where the runs are that were given to it. Nothing is written.
    ///
    /// # Errors
    /// [`SchedulerError`] if it cannot be asked.
    fn poll(&self, campaign: &Campaign) -> Result<Jobs, SchedulerError>;

    /// Ends all runs of a campaign that are queued or go on, these in good order. Returns how many jobs were asked to end.
    ///
    /// # Errors
    /// [`SchedulerError`] if it cannot be asked.
    fn cancel(&self, campaign: &Campaign) -> Result<usize, SchedulerError>;

    /// Takes up what ended since the last time: into the journal of the campaign, and into its data set. For the process alone that has the
    /// folder; `flow` can stop it, and the same call goes on.
    ///
    /// # Errors
    /// [`SchedulerError`] if it cannot be asked, or a file cannot be read or written.
    fn collect(
        &self,
        campaign: &Campaign,
        flow: &(dyn Fn() -> Flow + Sync),
    ) -> Result<Collected, SchedulerError>;
}

/// What is given to a scheduler.
#[derive(Clone, Copy)]
pub struct Order<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Its folder, which this process alone uses.
    pub folder: &'a OutputFolder,
    /// The laboratory, which says which runs are those of this version.
    pub laboratory: &'a Laboratory,
    /// True if folders that hold a run of another case or version are replaced.
    pub replace_others: bool,
    /// True if runs that failed for a reason that lies in their case are tried again.
    pub again: bool,
    /// Seconds for each unit of expected work, by which runs are packed, if it is known.
    pub pace: Option<f64>,
}

/// What became of runs that were given to a scheduler.
#[derive(Clone, Debug, PartialEq)]
pub enum Submitted {
    /// They have been executed.
    Ended(Summary),
    /// They are queued.
    Queued(Submission),
}

/// Runs that were queued.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Submission {
    /// The names that the scheduler gave to the jobs.
    pub jobs: Vec<String>,
    /// Number of elements of these jobs.
    pub elements: usize,
    /// Number of runs in them; samples are not counted.
    pub runs: usize,
    /// Number of runs for which the scheduler has no room at present, and why.
    pub waiting: Option<(usize, String)>,
}

/// A kind of scheduler.
#[derive(Clone, Copy, Debug)]
pub struct SchedulerKind {
    /// Its name.
    pub name: &'static str,
    /// What it does, in a sentence.
    pub help: &'static str,
    /// Makes one.
    pub make: fn(SchedulerOptions) -> Box<dyn Scheduler>,
}

/// How runs are executed; a scheduler takes what concerns it.
#[derive(Clone, Debug, Default)]
pub struct SchedulerOptions {
    /// The file of this program, by which runs are executed.
    pub program: PathBuf,
    /// Further arguments of this program, such as the interval of checkpoints.
    pub arguments: Vec<OsString>,
    /// Number of runs at once.
    pub workers: Option<usize>,
    /// The time after which all runs here end in good order.
    pub stop_after: Option<Duration>,
    /// The time of a job.
    pub time: Option<Duration>,
    /// Number of runs in an element of a job; otherwise as many as the time of a job holds.
    pub per_task: Option<usize>,
    /// The part of a cluster.
    pub partition: Option<String>,
    /// The account that is charged.
    pub account: Option<String>,
    /// Text at the beginning of the script of a job.
    pub header: Option<String>,
}
