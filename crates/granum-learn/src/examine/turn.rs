//! Work through a list of fits, with progress that can be stopped.

use granum_core::observer::{Flow, Observer, Progress};

use crate::error::{LearnError, Result};

/// Counts the fits of a question and asks the observer whether to go on.
pub(super) struct Turn<'a> {
    observer: &'a mut dyn Observer,
    done: usize,
    total: usize,
}

impl<'a> Turn<'a> {
    /// For so many fits.
    pub fn new(total: usize, observer: &'a mut dyn Observer) -> Turn<'a> {
        Turn { observer, done: 0, total }
    }

    /// The next fit.
    ///
    /// # Errors
    /// [`LearnError::Stopped`] if the observer wants no more.
    pub fn next(&mut self, what: impl Into<String>) -> Result<()> {
        let progress = Progress::new("comparison", "surrogates", self.done as u64).out_of(self.total as u64);
        if self.observer.progress(&progress.part(what.into())) == Flow::Stop {
            return Err(LearnError::Stopped { done: self.done, total: self.total });
        }
        self.done += 1;
        Ok(())
    }
}
