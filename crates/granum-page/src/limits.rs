//! How much a client may ask for, and how long it may take.

use std::time::Duration;

/// How much a client may ask for, and how long it may take. A browser on the same computer needs far less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Time in which the head of a request must have arrived, also of the next one of a connection that is kept.
    pub head: Duration,
    /// Time after which a connection takes no further request.
    pub connection: Duration,
    /// Time that it then has to take the rest of an answer.
    pub rest: Duration,
    /// Connections at a time; further ones wait until one ends.
    pub connections: usize,
    /// Requests that compute at a time.
    pub working: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            head: Duration::from_secs(10),
            connection: Duration::from_secs(120),
            rest: Duration::from_secs(60),
            connections: 64,
            working: std::thread::available_parallelism().map_or(2, usize::from).clamp(2, 8),
        }
    }
}

impl Limits {
    /// The same with changes.
    pub fn with(mut self, change: impl FnOnce(&mut Limits)) -> Limits {
        change(&mut self);
        self
    }
}
