//! Observers of a study.

use granum_core::observer::Progress;

use crate::error::Result;
use crate::methods::networks::{NetworkCheckpoints, NoCheckpoints};
use crate::surrogate::Surrogate;

/// An observer of the training of a study, which may store its surrogates and their networks, and may stop it, also within a
/// fit. Every method has a default that does nothing. Several threads call it.
///
/// ```
/// use std::sync::atomic::{AtomicUsize, Ordering};
///
/// use granum_learn::study::StudyObserver;
/// use granum_learn::{Result, Surrogate};
///
/// /// Counts the surrogates, and stops the study after the third.
/// #[derive(Default)]
/// struct Three(AtomicUsize);
///
/// impl StudyObserver for Three {
///     fn fitted(&self, _name: &str, _surrogate: &dyn Surrogate) -> Result<()> {
///         self.0.fetch_add(1, Ordering::Relaxed);
///         Ok(())
///     }
///     fn stop(&self) -> bool {
///         self.0.load(Ordering::Relaxed) >= 3
///     }
/// }
/// assert!(!Three::default().stop());
/// ```
pub trait StudyObserver: Sync {
    /// Called before a surrogate is fitted, with its name, its number from 1, and the number of all.
    fn begins(&self, _name: &str, _number: usize, _all: usize) {}

    /// Called while a surrogate is fitted, with its name; the part of the progress is the network that is trained.
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

    /// What keeps the networks of a surrogate while it is fitted.
    fn networks(&self) -> &dyn NetworkCheckpoints {
        &NoCheckpoints
    }

    /// Returns true to stop the training.
    fn stop(&self) -> bool {
        false
    }
}

/// An observer of a study that does nothing.
pub struct NoStudyObserver;

impl StudyObserver for NoStudyObserver {}
