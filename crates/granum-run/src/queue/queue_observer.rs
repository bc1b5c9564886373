//! What follows a queue of runs.

use granum_core::observer::{self as general, Event, SharedObserver};
use granum_dem::observer::{Flow, Observer, Progress, Work};

use super::outcome::Outcome;
use super::runner::Queue;

/// Follows the runs of a queue, which are given by their numbers in [`Queue::runs`](super::Queue::runs), from 0. It is called from
/// several threads and cannot change a result.
pub trait QueueObserver: Sync {
    /// A run begins or continues.
    fn begins(&self, run: usize) {
        let _ = run;
    }

    /// The progress of a run; returns whether it continues. A stop ends it in good order, with a checkpoint.
    fn progress(&self, run: usize, progress: &Progress) -> Flow {
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

/// An observer of any work as an observer of a queue: it receives owned data only, with the name of the run as the part.
pub struct QueueFollower<'a> {
    names: Vec<String>,
    shared: SharedObserver<'a>,
}

impl<'a> QueueFollower<'a> {
    /// Lets an observer follow a queue.
    pub fn new(queue: &Queue, observer: &'a mut dyn general::Observer) -> QueueFollower<'a> {
        let names = queue.runs().iter().map(|run| run.name.clone()).collect();
        QueueFollower { names, shared: SharedObserver::new(observer) }
    }
}

impl QueueObserver for QueueFollower<'_> {
    fn progress(&self, run: usize, progress: &Progress) -> Flow {
        general::Observer::progress(&mut self.shared.part(&self.names[run]), &progress.report())
    }

    fn warn(&self, run: usize, text: &str) {
        let name = &self.names[run];
        let event = Event::Warning { text: format!("{name}: {text}") };
        general::Observer::event(&mut self.shared.part(name), &event);
    }

    fn ends(&self, run: usize, outcome: &Outcome) {
        match outcome.failure() {
            Some(why) => self.warn(run, &format!("failed: {why}")),
            None if outcome.is_finished() => self.shared.part(&self.names[run]).completed(),
            None => {}
        }
    }

    fn flow(&self) -> Flow {
        if self.shared.stopped() { Flow::Stop } else { Flow::Continue }
    }
}

/// The observer of one run, which passes on what happens to that of its queue.
pub(super) struct OfOneRun<'a> {
    pub(super) observer: &'a dyn QueueObserver,
    pub(super) run: usize,
}

impl Observer for OfOneRun<'_> {
    fn progress(&mut self, progress: &Progress) -> Flow {
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
