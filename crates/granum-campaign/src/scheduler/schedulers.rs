//! The schedulers that a program knows. A new one needs a file in this folder and a line in [`Schedulers::standard`].

use granum_core::RegistrationError;

use super::job_record::JobRecord;
use super::scheduler_error::SchedulerError;
use super::scheduler_trait::{Scheduler, SchedulerKind, SchedulerOptions};
use super::{local, slurm};
use crate::campaign::Campaign;
use crate::jobs::Jobs;

/// The name of the scheduler that is taken if none is named.
pub const DEFAULT: &str = local::KIND.name;

/// The registry of the schedulers of a program.
///
/// ```
/// use granum_campaign::scheduler::{SchedulerOptions, Schedulers};
///
/// let schedulers = Schedulers::standard();
/// assert_eq!(schedulers.names().collect::<Vec<_>>(), ["local", "slurm"]);
/// assert!(schedulers.named("local", SchedulerOptions::default()).is_ok());
/// let error = schedulers.named("slrum", SchedulerOptions::default()).err().map(|error| error.to_string());
/// assert_eq!(error.as_deref(), Some("there is no scheduler \"slrum\"; there are: local, slurm"));
/// ```
#[derive(Clone, Debug)]
pub struct Schedulers(Vec<SchedulerKind>);

impl Default for Schedulers {
    fn default() -> Schedulers {
        Schedulers::standard()
    }
}

impl Schedulers {
    /// The schedulers that come with granum, starting with the default.
    pub fn standard() -> Schedulers {
        Schedulers(vec![local::KIND, slurm::KIND])
    }

    /// Adds a kind of scheduler.
    ///
    /// # Errors
    /// [`RegistrationError::Name`] if there is already a scheduler of the same name, or the name is not a word.
    pub fn with(mut self, kind: SchedulerKind) -> Result<Schedulers, RegistrationError> {
        RegistrationError::check_name("scheduler", kind.name, self.names())?;
        self.0.push(kind);
        Ok(self)
    }

    /// The kinds, starting with the default.
    pub fn all(&self) -> &[SchedulerKind] {
        &self.0
    }

    /// Their names, starting with the default.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|kind| kind.name)
    }

    /// The scheduler of the given name.
    ///
    /// # Errors
    /// [`SchedulerError::Unknown`].
    pub fn named(&self, name: &str, options: SchedulerOptions) -> Result<Box<dyn Scheduler>, SchedulerError> {
        let kind = self.0.iter().find(|kind| kind.name == name);
        let unknown = || SchedulerError::Unknown {
            name: name.to_string(),
            known: self.names().collect::<Vec<_>>().join(", "),
        };
        kind.map(|kind| (kind.make)(options)).ok_or_else(unknown)
    }

    /// Asks all schedulers that the jobs of a campaign name where its runs are.
    ///
    /// # Errors
    /// [`SchedulerError`] if one cannot be asked.
    pub fn poll(&self, campaign: &Campaign) -> Result<Jobs, SchedulerError> {
        let mut names: Vec<String> =
            JobRecord::open_in(campaign.folder())?.into_iter().map(|record| record.scheduler).collect();
        names.sort();
        names.dedup();
        let mut all = Jobs::default();
        for name in names {
            let found = self.named(&name, SchedulerOptions::default())?.poll(campaign)?;
            all.places.extend(found.places);
            all.jobs.extend(found.jobs);
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scheduler_is_added_once() {
        let other = SchedulerKind { name: "queue", ..local::KIND };
        let schedulers = Schedulers::standard().with(other).unwrap();
        assert_eq!(schedulers.all().last().unwrap().name, "queue");
        assert!(schedulers.named("queue", SchedulerOptions::default()).is_ok());
        let error = schedulers.with(local::KIND).unwrap_err();
        assert_eq!(error, RegistrationError::name_taken("scheduler", "local"));
    }
}
