//! What is said to a person while a process waits for another one.

use std::time::{Duration, Instant};

/// After this time the first words are said.
const FIRST: Duration = Duration::from_secs(5);
/// Time between later ones.
const AGAIN: Duration = Duration::from_secs(30);

/// Tells now and then for whom a process waits, and for how long it has.
#[derive(Debug)]
pub struct Waiting {
    since: Instant,
    next: Duration,
}

impl Default for Waiting {
    fn default() -> Waiting {
        Waiting::after(FIRST)
    }
}

impl Waiting {
    /// The first words are due after this time.
    pub fn after(first: Duration) -> Waiting {
        Waiting { since: Instant::now(), next: first }
    }

    /// The words that are due, which `who` completes from how long it has been waited; to be called again and again.
    pub fn words(&mut self, who: impl FnOnce(Duration) -> String) -> Option<String> {
        let waited = self.since.elapsed();
        if waited < self.next {
            return None;
        }
        self.next = waited + AGAIN;
        Some(format!("has waited {} s for {}", waited.as_secs(), who(waited)))
    }

    #[cfg(test)]
    pub(super) fn as_if_begun(before: Duration) -> Waiting {
        let since = Instant::now().checked_sub(before).unwrap_or_else(Instant::now);
        Waiting { since, next: FIRST }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_said_first_after_seconds_and_then_now_and_then() {
        let who = |_| "process 7".to_string();
        assert_eq!(Waiting::default().words(who), None);
        let mut waiting = Waiting::as_if_begun(Duration::from_secs(12));
        assert_eq!(waiting.words(who).as_deref(), Some("has waited 12 s for process 7"));
        assert_eq!(waiting.words(who), None);
    }
}
