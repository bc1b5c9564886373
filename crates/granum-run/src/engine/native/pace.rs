//! When a checkpoint is due.

use std::time::Duration;

use granum_core::clock::Instant;

/// Determines when a checkpoint is due. It never is at the first observation of a segment, so that the run makes progress
/// even if the interval is very short.
pub(crate) struct Interval {
    since: Option<Instant>,
    every: Duration,
}

impl Interval {
    pub(crate) fn new(every: Duration) -> Interval {
        Interval { since: None, every }
    }

    pub(crate) fn is_over(&mut self) -> bool {
        match self.since {
            Some(since) => since.elapsed() > self.every,
            None => {
                self.since = Some(Instant::now());
                false
            }
        }
    }
}
