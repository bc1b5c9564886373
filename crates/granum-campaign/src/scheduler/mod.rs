//! Schedulers: who executes the runs of a campaign, and where.
//!
//! A scheduler has a file of its own here and a line in [`Schedulers::standard`]; a program adds its own with [`Schedulers::with`].

mod job_record;
mod local;
mod packing;
mod scheduler_error;
mod scheduler_trait;
mod schedulers;
mod slurm;

pub use crate::jobs::{JobState, Jobs, Place};
pub use job_record::{JOBS, JobRecord, element_journal};
pub use scheduler_error::SchedulerError;
pub use scheduler_trait::{Order, Scheduler, SchedulerKind, SchedulerOptions, Submission, Submitted};
pub use schedulers::{DEFAULT, Schedulers};
