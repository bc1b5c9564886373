//! The processors that several runs share.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The processors that several runs share: a single run gets all of them, and many runs get one each.
#[derive(Debug, Default)]
pub struct Shared {
    running: AtomicUsize,
}

impl Shared {
    /// Number of the runs that are registered.
    pub(crate) fn running(&self) -> usize {
        self.running.load(Ordering::Relaxed)
    }

    /// Registers a run until the returned value is dropped.
    pub fn enter(self: &Arc<Self>) -> Entered {
        self.running.fetch_add(1, Ordering::Relaxed);
        Entered(self.clone())
    }
}

/// The registration of a run that shares the processors; dropping it ends the registration.
pub struct Entered(Arc<Shared>);

impl Drop for Entered {
    fn drop(&mut self) {
        self.0.running.fetch_sub(1, Ordering::Relaxed);
    }
}
