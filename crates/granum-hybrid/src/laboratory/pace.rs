//! When a checkpoint is due, and how fast a run goes.

use std::time::{Duration, Instant};

use granum_dem::simulation::Simulation;

/// Says when a checkpoint is due. Never at the first look of a stretch: a stretch must get on, however short the interval.
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

/// Grain-steps per second, from stretch to stretch.
pub(crate) struct Speedometer {
    since: Instant,
    /// Step at that time; none before the first look.
    step: Option<u64>,
    rate: f64,
}

impl Speedometer {
    pub(crate) fn new() -> Self {
        Speedometer { since: Instant::now(), step: None, rate: 0.0 }
    }

    pub(crate) fn rate(&mut self, simulation: &Simulation) -> f64 {
        let step = simulation.state().step();
        let seconds = self.since.elapsed().as_secs_f64();
        match self.step {
            Some(before) if before <= step => {
                if seconds > 0.5 {
                    let steps = (step - before) as f64;
                    let rate = steps * simulation.state().grains() as f64 / seconds;
                    *self = Speedometer { step: Some(step), rate, since: Instant::now() };
                }
            }
            // Another phase has begun.
            _ => *self = Speedometer { step: Some(step), rate: self.rate, since: Instant::now() },
        }
        self.rate
    }
}
