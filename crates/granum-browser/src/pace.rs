//! An observer that stops a run after a time of the wall, so that a page can breathe.

use std::time::Duration;

use granum_core::clock::Instant;
use granum_core::observer::{Event, Flow, Observer, Progress};

/// Stops a piece when its time is over, and remembers the last progress and the warnings.
pub(crate) struct Pace {
    begun: Instant,
    most: Duration,
    pub(crate) last: Option<Progress>,
    pub(crate) warnings: Vec<String>,
}

impl Pace {
    pub(crate) fn new(most: Duration) -> Pace {
        Pace { begun: Instant::now(), most, last: None, warnings: Vec::new() }
    }
}

impl Observer for Pace {
    fn progress(&mut self, progress: &Progress) -> Flow {
        self.last = Some(progress.clone());
        if self.begun.elapsed() >= self.most { Flow::Stop } else { Flow::Continue }
    }
    fn event(&mut self, event: &Event) {
        if let Event::Warning { text } = event {
            self.warnings.push(text.clone());
        }
    }
}
