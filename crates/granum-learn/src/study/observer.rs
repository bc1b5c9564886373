//! Observers of a study.

use granum_core::observer::Progress;

use crate::error::Result;
use crate::surrogate::Surrogate;

/// An observer of the training of a study, which may store its surrogates and may stop it, also within a fit. Every method has
/// a default that does nothing.
pub trait StudyObserver: Sync {
    /// Called before a surrogate is fitted, with its name, its number from 1, and the number of all.
    fn begins(&self, _name: &str, _number: usize, _all: usize) {}

    /// Called while a surrogate is fitted, with its name.
    fn progress(&self, _name: &str, _progress: &Progress) {}

    /// A surrogate of an earlier, unfinished training of the same study.
    ///
    /// # Errors
    /// If it cannot be read.
    fn finished(&self, _name: &str) -> Result<Option<Box<dyn Surrogate>>> {
        Ok(None)
    }

    /// Called when a surrogate is fitted.
    ///
    /// # Errors
    /// If it cannot be stored, which ends the training.
    fn fitted(&self, _name: &str, _surrogate: &dyn Surrogate) -> Result<()> {
        Ok(())
    }

    /// Returns true to stop the training.
    fn stop(&self) -> bool {
        false
    }
}

/// An observer that does nothing.
pub struct Silent;

impl StudyObserver for Silent {}
