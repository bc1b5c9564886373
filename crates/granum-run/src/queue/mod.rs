//! A queue of runs: planned runs with their names, cases and folders, of which as many are executed at once as there are
//! processors, the longest first. A run that fails does not stop the others, an interruption ends all of them in good order, and
//! the same queue continues what is unfinished and uses again what is finished.
//!
//! ```
//! use granum_io::Case;
//! use granum_run::queue::{NoQueueObserver, Outcome, Queue, QueuedRun};
//! use granum_run::{Laboratory, Source};
//!
//! # let base = tempfile::tempdir()?;
//! let text = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
//!             shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2";
//! let case = Case::parse(text, "case")?;
//! let mut runs = Vec::new();
//! for strain in ["0.01", "0.02"] {
//!     let mut case = case.clone();
//!     case.set("shear.deviator_strain", strain)?;
//!     let name = format!("deviator_strain={strain}");
//!     runs.push(QueuedRun::test(&name, case, Source::Case, base.path().join(&name)));
//! }
//! // Both tests have the same sample, which is prepared once.
//! let queue = Queue::with_shared_samples(runs, &base.path().join("samples"))?;
//! assert_eq!(queue.runs().len(), 3);
//! let outcomes = queue.run(&Laboratory::here(), &NoQueueObserver);
//! assert!(outcomes.iter().all(|outcome| matches!(outcome, Outcome::Finished { reused: false, .. })));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod combinations;
mod execution;
mod executor;
mod outcome;
mod queue_error;
mod queue_follower;
mod queue_observer;
mod queued_run;
mod run_list;
mod runner;
mod samples;
mod schedule;
mod shares;
mod work;

pub(crate) use combinations::short_keys;
pub use combinations::{MOST_COMBINATIONS, Setting, combinations, names};
pub use executor::{Executor, InThisProcess};
pub use granum_io::run::RunKind;
pub use outcome::{Outcome, RunError};
pub use queue_error::QueueError;
pub use queue_follower::QueueFollower;
pub use queue_observer::{NoQueueObserver, QueueObserver};
pub use queued_run::QueuedRun;
pub use run_list::{RUN_LIST, RunList};
pub use runner::Queue;
pub use samples::sample_name;
pub use shares::{Shares, TEST_BEGINS_AT};

#[cfg(test)]
mod tests;
