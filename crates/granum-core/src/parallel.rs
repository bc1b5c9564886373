//! Independent pieces of work on several threads, with results in the order of the pieces.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::iter::{ParallelBridge, ParallelIterator};

/// Number of threads of this machine.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |threads| threads.get())
}

/// Calls `work(k)` for every `k < count` on up to `threads` threads (0: as many as the machine has), started in the order of
/// k. The result of a piece does not depend on the threads. After the first error no further piece is started, and the error
/// of the failed piece with the lowest index is returned.
///
/// ```
/// let squares: Result<Vec<usize>, ()> = granum_core::parallel::map(4, 2, |k| Ok(k * k));
/// assert_eq!(squares.unwrap(), [0, 1, 4, 9]);
/// ```
///
/// # Errors
/// The error of the failed piece with the lowest index.
pub fn map<R: Send, E: Send>(
    count: usize,
    threads: usize,
    work: impl Fn(usize) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let threads = if threads == 0 { available_threads() } else { threads }.min(count);
    let failed = AtomicUsize::new(0);
    let piece = |k: usize| {
        if failed.load(Ordering::Relaxed) > 0 {
            return None;
        }
        let result = work(k);
        failed.fetch_add(usize::from(result.is_err()), Ordering::Relaxed);
        Some((k, result))
    };
    // Without a thread pool (if the system refused the threads) the calling thread does the work.
    let pool =
        (threads > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
    let mut results: Vec<(usize, Result<R, E>)> = match pool {
        Some(pool) => pool.install(|| (0..count).par_bridge().filter_map(piece).collect()),
        None => (0..count).filter_map(piece).collect(),
    };
    results.sort_by_key(|(k, _)| *k);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_whatever_the_threads() {
        for threads in [0, 1, 2, 7] {
            let squares: Result<Vec<usize>, ()> = map(50, threads, |k| Ok(k * k));
            assert_eq!(squares.unwrap(), (0..50).map(|k| k * k).collect::<Vec<_>>());
        }
        assert_eq!(map(0, 2, |_| Ok::<u8, ()>(1)).unwrap(), Vec::<u8>::new());
    }

    #[test]
    fn an_error_ends_the_work() {
        let done = AtomicUsize::new(0);
        let result: Result<Vec<()>, usize> = map(10_000, 2, |k| {
            done.fetch_add(1, Ordering::Relaxed);
            if k == 5 { Err(k) } else { Ok(()) }
        });
        assert_eq!(result, Err(5));
        assert!(done.load(Ordering::Relaxed) < 10_000);
    }
}
