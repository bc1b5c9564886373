//! The registry of schedulers. A new scheduler needs a file in this folder and a line in [`ALL`].

use super::job_record::JobRecord;
use super::jobs::Jobs;
use super::scheduler_error::SchedulerError;
use super::scheduler_trait::{Scheduler, SchedulerKind, SchedulerOptions};
use super::{local, slurm};
use crate::campaign::Campaign;

/// The schedulers, starting with the default.
pub const ALL: [&SchedulerKind; 2] = [&local::KIND, &slurm::KIND];

/// The names that [`by_name`] accepts, starting with the default.
pub fn names() -> [&'static str; ALL.len()] {
    ALL.map(|kind| kind.name)
}

/// The name of the scheduler that is taken if none is named.
pub const DEFAULT: &str = local::KIND.name;

/// The scheduler of the given name, see [`names`].
///
/// ```
/// use granum_campaign::scheduler::{self, SchedulerOptions};
///
/// assert!(scheduler::by_name("local", SchedulerOptions::default()).is_ok());
/// let error = scheduler::by_name("slrum", SchedulerOptions::default()).err().map(|error| error.to_string());
/// assert_eq!(error.as_deref(), Some("there is no scheduler \"slrum\"; there are: local, slurm"));
/// ```
///
/// # Errors
/// [`SchedulerError::Unknown`].
pub fn by_name(name: &str, options: SchedulerOptions) -> Result<Box<dyn Scheduler>, SchedulerError> {
    let kind = ALL.iter().find(|kind| kind.name == name);
    let unknown = || SchedulerError::Unknown { name: name.to_string(), known: names().join(", ") };
    kind.map(|kind| (kind.make)(options)).ok_or_else(unknown)
}

/// Asks all schedulers that the jobs of a campaign name where its runs are.
///
/// # Errors
/// [`SchedulerError`] if one cannot be asked.
pub fn poll(campaign: &Campaign) -> Result<Jobs, SchedulerError> {
    let mut names: Vec<String> =
        JobRecord::open_in(campaign.folder())?.into_iter().map(|record| record.scheduler).collect();
    names.sort();
    names.dedup();
    let mut all = Jobs::default();
    for name in names {
        let found = by_name(&name, SchedulerOptions::default())?.poll(campaign)?;
        all.places.extend(found.places);
        all.jobs.extend(found.jobs);
    }
    Ok(all)
}
