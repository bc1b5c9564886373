//! A handful of threads that walk through the stages of many steps together.
//!
//! A step of a few thousand grains takes some tens of microseconds, too short for a task scheduler, so the threads stay and
//! meet at spinning barriers. Work is split by fixed chunks whose results are summed in the order of the chunks:
//! the number of threads cannot change a bit.
//!
//! All `unsafe` of the engine's threading is here: [`RawSlice`] hands disjoint pieces of one array to several threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A barrier that spins for a while before it yields the processor.
pub(crate) struct Barrier {
    threads: usize,
    arrived: AtomicUsize,
    generation: AtomicUsize,
}

impl Barrier {
    pub(crate) fn new(threads: usize) -> Barrier {
        Barrier { threads, arrived: AtomicUsize::new(0), generation: AtomicUsize::new(0) }
    }

    /// Returns when every thread has called it as often.
    #[inline]
    pub(crate) fn wait(&self) {
        if self.threads == 1 {
            return;
        }
        let generation = self.generation.load(Ordering::Relaxed);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.threads {
            self.arrived.store(0, Ordering::Relaxed);
            self.generation.store(generation.wrapping_add(1), Ordering::Release);
            return;
        }
        let mut spins = 0u32;
        while self.generation.load(Ordering::Acquire) == generation {
            spins += 1;
            // On a machine with fewer free cores than threads spinning on would starve the thread waited for.
            if spins > 4_000 { std::thread::yield_now() } else { std::hint::spin_loop() }
        }
    }
}

/// An array seen by all threads of a team.
pub(crate) struct RawSlice<T> {
    start: *mut T,
    len: usize,
}

impl<T> Clone for RawSlice<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for RawSlice<T> {}
// SAFETY: the two accessors below are unsafe and state what their callers owe.
unsafe impl<T: Send> Send for RawSlice<T> {}
unsafe impl<T: Send> Sync for RawSlice<T> {}

impl<T> RawSlice<T> {
    pub(crate) fn new(slice: &mut [T]) -> RawSlice<T> {
        RawSlice { start: slice.as_mut_ptr(), len: slice.len() }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The whole array for reading.
    ///
    /// # Safety
    /// The array that it was made from is alive and has not been moved, and no thread writes it before the next barrier.
    #[inline(always)]
    pub(crate) unsafe fn read<'a>(&self) -> &'a [T] {
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }

    /// A piece for writing.
    ///
    /// # Safety
    /// As for [`RawSlice::read`], and no other thread reads or writes this piece before the next barrier.
    #[inline(always)]
    pub(crate) unsafe fn write<'a>(&self, range: Range<usize>) -> &'a mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        unsafe { std::slice::from_raw_parts_mut(self.start.add(range.start), range.end - range.start) }
    }
}

impl<T> RawSlice<T> {
    /// Asks for the cache line of an element; a hint that reads nothing.
    #[inline(always)]
    pub(crate) fn prefetch(&self, index: usize) {
        if index < self.len {
            granum_simd::prefetch(self.start.wrapping_add(index));
        }
    }

    /// Panics unless all these are indices of the array.
    #[inline(always)]
    pub(crate) fn check(&self, index: &[u32; 8]) {
        let largest = index.iter().fold(0, |most, &i| if i > most { i } else { most });
        assert!((largest as usize) < self.len, "row {largest} of {}", self.len);
    }

    /// One element for writing.
    ///
    /// # Safety
    /// As for [`RawSlice::write`], the index is within the array, and no other reference to this element is alive.
    #[inline(always)]
    pub(crate) unsafe fn at<'a>(&self, index: u32) -> &'a mut T {
        unsafe { &mut *self.start.add(index as usize) }
    }
}

/// The share of thread `t` of `threads` in `count` chunks: contiguous, sizes differing by one at most.
pub(crate) fn share(count: usize, t: usize, threads: usize) -> Range<usize> {
    count * t / threads..count * (t + 1) / threads
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cover_everything_once() {
        for count in [0, 1, 7, 100] {
            for threads in 1..6 {
                let all: Vec<usize> = (0..threads).flat_map(|t| share(count, t, threads)).collect();
                assert_eq!(all, (0..count).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn barrier_separates_stages() {
        let barrier = Barrier::new(3);
        let counter = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    for round in 1..200 {
                        counter.fetch_add(1, Ordering::SeqCst);
                        barrier.wait();
                        assert_eq!(counter.load(Ordering::SeqCst), 3 * round);
                        barrier.wait();
                    }
                });
            }
        });
    }
}
