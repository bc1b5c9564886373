//! Networks that are trained at the same time, each without a part of the runs.

use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Observer, SharedObserver};
use granum_core::parallel;
use granum_nets::trainer::TerminationReason;

use crate::error::{LearnError, Result};

/// The networks `0..count`; `train` trains the network of a number, and tells its observer of it.
///
/// # Errors
/// Those of `train`, and [`LearnError::Stopped`] if the observer stops the training.
pub(super) fn networks_of_parts<T: Send>(
    count: usize,
    threads: usize,
    observer: &mut dyn Observer,
    train: impl Fn(usize, &mut dyn Observer) -> Result<(T, TerminationReason)> + Sync,
) -> Result<Vec<T>> {
    let shared = SharedObserver::new(observer);
    let done = AtomicUsize::new(0);
    let stopped = || LearnError::Stopped { done: done.load(Ordering::Relaxed), total: count };
    parallel::map(count, threads, |k| {
        if shared.stopped() {
            return Err(stopped());
        }
        let mut part = shared.part(format!("network {}", k + 1));
        let (network, termination) = train(k, &mut part)?;
        if termination == TerminationReason::Stopped {
            return Err(stopped());
        }
        done.fetch_add(1, Ordering::Relaxed);
        part.completed();
        Ok(network)
    })
}
