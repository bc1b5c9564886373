//! Work through a list of fits, with progress that can be stopped.

use granum_core::observer::{Event, Flow, Observer, Progress};

use crate::error::{LearnError, Result};

/// Counts the fits of a question and asks the observer whether to go on.
pub(super) struct Turn<'a> {
    observer: &'a mut dyn Observer,
    done: usize,
    total: usize,
    /// What the present fit is of.
    what: String,
}

/// Follows the present fit: the observer hears of its parts, and can stop it.
struct Within<'a, 'b>(&'a mut Turn<'b>);

impl<'a> Turn<'a> {
    /// For so many fits.
    pub fn new(total: usize, observer: &'a mut dyn Observer) -> Turn<'a> {
        Turn { observer, done: 0, total, what: String::new() }
    }

    /// The next fit.
    ///
    /// # Errors
    /// [`LearnError::Stopped`] if the observer wants no more.
    pub fn next(&mut self, what: impl Into<String>) -> Result<()> {
        self.what = what.into();
        if self.told(None) == Flow::Stop {
            return Err(self.stopped());
        }
        self.done += 1;
        Ok(())
    }

    /// Carries out the present fit, with an observer that can stop it.
    ///
    /// # Errors
    /// Those of the fit, and [`LearnError::Stopped`] with the number of fits that are complete.
    pub fn work<T>(&mut self, fit: impl FnOnce(&mut dyn Observer) -> Result<T>) -> Result<T> {
        self.done = self.done.saturating_sub(1);
        let found = fit(&mut Within(self));
        match found {
            Err(LearnError::Stopped { .. }) => Err(self.stopped()),
            found => {
                self.done += 1;
                found
            }
        }
    }

    fn stopped(&self) -> LearnError {
        LearnError::Stopped { done: self.done, total: self.total }
    }

    /// Tells where the work is.
    fn told(&mut self, part: Option<&str>) -> Flow {
        let what = match part {
            Some(part) => format!("{}, {part}", self.what),
            None => self.what.clone(),
        };
        let progress = Progress::new("comparison", "surrogates", self.done as u64).out_of(self.total as u64);
        self.observer.progress(&progress.part(what))
    }
}

impl Observer for Within<'_, '_> {
    fn progress(&mut self, step: &Progress) -> Flow {
        self.0.told(step.part.as_deref())
    }

    fn event(&mut self, event: &Event) {
        self.0.observer.event(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stops at the third thing that it hears of.
    #[derive(Default)]
    struct Third(Vec<String>);

    impl Observer for Third {
        fn progress(&mut self, step: &Progress) -> Flow {
            self.0.push(step.part.clone().unwrap_or_default());
            if self.0.len() < 3 { Flow::Continue } else { Flow::Stop }
        }
    }

    #[test]
    fn a_fit_is_followed_and_stopped_within() {
        let mut observer = Third::default();
        let mut turn = Turn::new(5, &mut observer);
        turn.next("first").unwrap();
        turn.work(|_| Ok(())).unwrap();
        turn.next("second").unwrap();
        let stopped: Result<()> = turn.work(|observer| {
            let step = Progress::new("training", "epochs", 7).out_of(9).part("network 1".to_owned());
            assert_eq!(observer.progress(&step), Flow::Stop);
            Err(LearnError::Stopped { done: 7, total: 9 })
        });
        assert!(matches!(stopped, Err(LearnError::Stopped { done: 1, total: 5 })), "{stopped:?}");
        assert_eq!(observer.0, ["first", "second", "second, network 1"]);
    }
}
