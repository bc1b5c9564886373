//! The progress of a queue of runs on the terminal.

use std::sync::{Mutex, MutexGuard, PoisonError};

use granum_run::laboratory::{self, ProgressField};
use granum_run::queue::{Outcome, Queue, QueueObserver, Shares};
use granum_run::{Flow, SimulationProgress};

use crate::context::Context;
use crate::progress::{Progress, Room};

/// Shows the progress of all runs in one line, and stops them when the user asks for it.
pub struct ShowQueue<'a> {
    context: &'a Context,
    /// What a run is called in the line, e.g. `seed 11`.
    labels: Vec<String>,
    shown: Mutex<(Progress, Shares)>,
}

impl<'a> ShowQueue<'a> {
    /// A display of a phase with a name for each run.
    pub fn new(context: &'a Context, queue: &Queue, phase: &str, labels: Vec<String>) -> ShowQueue<'a> {
        let mut progress = context.progress();
        progress.phase(phase);
        ShowQueue { context, labels, shown: Mutex::new((progress, Shares::new(queue))) }
    }

    /// Ends the display with a permanent line.
    pub fn end(self, text: impl FnOnce() -> String) {
        let (mut progress, _) = self.shown.into_inner().unwrap_or_else(PoisonError::into_inner);
        progress.end(text);
    }

    fn lock(&self) -> MutexGuard<'_, (Progress, Shares)> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl QueueObserver for ShowQueue<'_> {
    fn progress(&self, run: usize, status: &SimulationProgress) -> Flow {
        let mut held = self.lock();
        let (progress, shares) = &mut *held;
        shares.update(run, status);
        let (label, phase) = (&self.labels[run], status.phase.name());
        progress.update(Some(shares.all()), |room| match room {
            Room::Line => {
                vec![ProgressField::new(0, format!("{label} {phase}  {}", laboratory::line(status)))]
            }
            Room::Screen => {
                let mut fields = vec![ProgressField::new(0, label.clone()), ProgressField::new(4, phase)];
                fields.extend(laboratory::fields(status));
                fields
            }
        });
        self.flow()
    }

    fn warn(&self, run: usize, text: &str) {
        // Held, so that the line of progress is not written in between.
        let _held = self.lock();
        self.context.warn(&format!("{}: {text}", self.labels[run]));
    }

    fn ends(&self, run: usize, outcome: &Outcome) {
        self.lock().1.end(run, outcome);
        if let Some(why) = outcome.failure() {
            self.warn(run, &format!("failed: {why}"));
        }
    }

    fn flow(&self) -> Flow {
        self.context.flow()
    }
}
