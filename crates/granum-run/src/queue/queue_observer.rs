//! What follows a queue of runs.

use granum_dem::observer::{Flow, SimulationObserver, SimulationProgress, Work};

use super::outcome::Outcome;

/// Follows the runs of a queue, which are given by their numbers in [`Queue::runs`](super::Queue::runs), from 0. It is called from
/// several threads and cannot change a result.
pub trait QueueObserver: Sync {
    /// A run begins or continues.
    fn begins(&self, run: usize) {
        let _ = run;
    }

    /// The progress of a run; returns whether it continues. A stop ends it in good order, with a checkpoint.
    fn progress(&self, run: usize, progress: &SimulationProgress) -> Flow {
        let _ = (run, progress);
        self.flow()
    }

    /// The completed share of a run that is executed elsewhere, from 0 to 1; returns whether it continues, as for
    /// [`QueueObserver::progress`].
    fn share(&self, run: usize, share: f64) -> Flow {
        let _ = (run, share);
        self.flow()
    }

    /// Something about a run that the user should know.
    fn warn(&self, run: usize, text: &str) {
        let _ = (run, text);
    }

    /// A run ended, or needs no work.
    fn ends(&self, run: usize, outcome: &Outcome) {
        let _ = (run, outcome);
    }

    /// Asked before every run: after [`Flow::Stop`] none is begun any more.
    fn flow(&self) -> Flow {
        Flow::Continue
    }
}

/// The observer of a queue that none follows.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoQueueObserver;

impl QueueObserver for NoQueueObserver {}

/// The observer of one run, which passes on what happens to that of its queue.
pub(super) struct OfOneRun<'a> {
    pub(super) observer: &'a dyn QueueObserver,
    pub(super) run: usize,
}

impl SimulationObserver for OfOneRun<'_> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        self.observer.progress(self.run, progress)
    }

    fn work(&mut self, work: &Work) -> Flow {
        match work {
            Work::Steps(progress) => self.observer.progress(self.run, progress),
            _ => self.observer.flow(),
        }
    }

    fn warn(&mut self, text: &str) {
        self.observer.warn(self.run, text);
    }
}
