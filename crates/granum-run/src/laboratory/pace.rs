//! When a checkpoint is due.

use std::time::{Duration, Instant};

/// Says when a checkpoint is due. Never at the first observation of a segment: a segment must get on, however short the interval.
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
