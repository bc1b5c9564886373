//! An observer of any work that follows a queue of runs.

use granum_core::observer::{Event, Flow, Observer, SharedObserver};
use granum_dem::observer::SimulationProgress;

use super::outcome::Outcome;
use super::queue_observer::QueueObserver;
use super::runner::Queue;

/// An observer of any work as an observer of a queue: it receives owned data only, with the name of the run as the part.
pub struct QueueFollower<'a> {
    names: Vec<String>,
    shared: SharedObserver<'a>,
}

impl<'a> QueueFollower<'a> {
    /// Lets an observer follow a queue.
    pub fn new(queue: &Queue, observer: &'a mut dyn Observer) -> QueueFollower<'a> {
        let names = queue.runs().iter().map(|run| run.name.clone()).collect();
        QueueFollower { names, shared: SharedObserver::new(observer) }
    }
}

impl QueueObserver for QueueFollower<'_> {
    fn progress(&self, run: usize, progress: &SimulationProgress) -> Flow {
        Observer::progress(&mut self.shared.part(&self.names[run]), &progress.report())
    }

    fn warn(&self, run: usize, text: &str) {
        let name = &self.names[run];
        let event = Event::Warning { text: format!("{name}: {text}") };
        Observer::event(&mut self.shared.part(name), &event);
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
