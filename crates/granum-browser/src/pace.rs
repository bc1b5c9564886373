//! An observer that stops a run after a time of the wall, so that a page can breathe.

use std::time::Duration;

use granum_core::clock::Instant;
use granum_core::observer::{Event, Flow, Progress};
use granum_dem::observer::{SimulationObserver, SimulationProgress, Work};

/// Grain-steps between two looks at the clock: a few milliseconds. A sample is prepared in stretches of hundreds of steps, which would be a large
/// part of a second with many grains on a slow machine, and no picture would be drawn before the end of one.
const LOOK_EVERY: u64 = 10_000;

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

    fn is_over(&self) -> bool {
        self.begun.elapsed() >= self.most
    }
}

impl SimulationObserver for Pace {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        self.last = Some(progress.report());
        if self.is_over() { Flow::Stop } else { Flow::Continue }
    }

    fn work(&mut self, work: &Work) -> Flow {
        if !self.is_over() {
            return Flow::Continue;
        }
        self.last = Some(work.report());
        Flow::Stop
    }

    fn work_every(&self) -> u64 {
        LOOK_EVERY
    }

    fn event(&mut self, event: &Event) {
        if let Event::Warning { text } = event {
            self.warnings.push(text.clone());
        }
    }
}
