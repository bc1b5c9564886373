//! Independent pieces of work over threads, results in the order of the pieces.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of threads of this machine.
pub(crate) fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |threads| threads.get())
}

/// Does `work(k)` for every `k < count` on up to `threads` threads (0: as many as the machine has). What each piece
/// gives cannot depend on the threads. After the first error no new piece is begun, and the error of the lowest
/// piece that failed is returned.
pub(crate) fn map<R: Send, E: Send>(
    count: usize,
    threads: usize,
    work: impl Fn(usize) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let threads = if threads == 0 { available_threads() } else { threads }.min(count);
    let next = AtomicUsize::new(0);
    let failed = AtomicUsize::new(usize::MAX);
    let results = Mutex::new(Vec::with_capacity(count));
    let run = || {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= count || failed.load(Ordering::Relaxed) != usize::MAX {
                return;
            }
            let result = work(k);
            if result.is_err() {
                failed.fetch_min(k, Ordering::Relaxed);
            }
            if let Ok(mut results) = results.lock() {
                results.push((k, result));
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(run);
        }
        run();
    });
    let mut results = results.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
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
