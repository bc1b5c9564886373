//! Who executes the runs of a queue.

use granum_io::RunRecord;

use super::execution::execute;
use super::outcome::RunError;
use super::queue_observer::{OfOneRun, QueueObserver};
use super::queued_run::QueuedRun;
use crate::laboratory::definition::Laboratory;

/// Executes the runs of a queue: in this process ([`InThisProcess`]), in a process each, or elsewhere. It is called from several
/// threads, from each for one run at a time, and returns when the run has ended.
pub trait Executor: Sync {
    /// Executes a run, given with its number in the queue, in its folder, or continues it. Progress and warnings go to the observer, and
    /// a run that the observer stops ends in good order.
    ///
    /// # Errors
    /// [`RunError`] if the run failed; the queue goes on with the others.
    fn execute(
        &self,
        number: usize,
        run: &QueuedRun,
        observer: &dyn QueueObserver,
    ) -> Result<RunRecord, RunError>;
}

/// Executes runs in this process, by the engine of a laboratory.
pub struct InThisProcess<'a>(pub &'a Laboratory);

impl Executor for InThisProcess<'_> {
    fn execute(
        &self,
        number: usize,
        run: &QueuedRun,
        observer: &dyn QueueObserver,
    ) -> Result<RunRecord, RunError> {
        let _entered = self.0.resources.shared.as_ref().map(|shared| shared.enter());
        execute(self.0, run, &mut OfOneRun { observer, run: number })
    }
}
