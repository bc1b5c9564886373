//! Schedulers: who executes the runs of a campaign, and where.
//!
//! A scheduler has a file of its own here and a line in [`ALL`].

mod job_record;
mod jobs;
mod local;
mod packing;
mod registry;
mod scheduler_error;
mod scheduler_trait;
mod slurm;

pub use job_record::{JOBS, JobRecord, element_journal};
pub use jobs::{JobState, Jobs, Place};
pub use registry::{ALL, DEFAULT, by_name, names, poll};
pub use scheduler_error::SchedulerError;
pub use scheduler_trait::{Order, Scheduler, SchedulerKind, SchedulerOptions, Submission, Submitted};
