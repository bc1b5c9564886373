//! A team of threads that execute the stages of many steps together.
//!
//! A step of a few thousand grains takes some tens of microseconds, which is too short for a task scheduler. The threads
//! therefore stay alive and claim blocks of the current stage; the thread that finishes the last block does the serial work
//! and opens the next stage. The blocks are fixed and their results are summed in their order, so that the number of threads
//! cannot change a single bit.
//!
//! All `unsafe` code of the engine's threading is here: [`RawSlice`] gives several threads access to disjoint parts of one
//! array.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// Number of bits of an index into the list of blocks; the other bits of a word count the stages.
const PLACE: u32 = 20;
const PLACES: u64 = (1 << PLACE) - 1;
/// Number of spins of an idle thread before it yields its processor.
const PATIENCE: u32 = 2_000;

/// The remaining blocks of a stage, from `low` to below `high`, with the number of the stage.
#[derive(Clone, Copy)]
struct Left {
    stage: u64,
    low: u64,
    high: u64,
}

impl Left {
    fn pack(self) -> u64 {
        self.stage << (2 * PLACE) | self.low << PLACE | self.high
    }
    fn unpack(word: u64) -> Left {
        Left { stage: word >> (2 * PLACE), low: word >> PLACE & PLACES, high: word & PLACES }
    }
}

/// An atomic number on its own cache line.
#[repr(align(128))]
struct Alone(AtomicU64);

/// The blocks of the current stage, with a share for every thread. A thread takes its own share piece by piece and then
/// helps the others: a thread that lost its processor to another program delays only the piece that it holds. The result of
/// a block does not depend on the thread that computed it.
pub(crate) struct Work {
    shares: Vec<Alone>,
    done: AtomicUsize,
    over: AtomicBool,
}

impl Work {
    pub(crate) fn new(threads: usize) -> Work {
        let none = || Alone(AtomicU64::new(0));
        Work {
            shares: (0..threads).map(|_| none()).collect(),
            done: AtomicUsize::new(0),
            over: AtomicBool::new(false),
        }
    }

    /// Opens a stage: from now on its blocks can be claimed. All data that the stage reads must have been written before.
    pub(crate) fn open(&self, share: impl Fn(usize) -> Range<usize>) {
        self.done.store(0, Ordering::Relaxed);
        for (thread, word) in self.shares.iter().enumerate() {
            let stage = Left::unpack(word.0.load(Ordering::Relaxed)).stage + 1;
            let range = share(thread);
            assert!(range.start <= range.end && range.end as u64 <= PLACES, "too many blocks");
            let left = Left { stage, low: range.start as u64, high: range.end as u64 };
            word.0.store(left.pack(), Ordering::Release);
        }
    }

    /// Claims a piece of the open stage, if one is left; the stage stays open until all of it is reported as done.
    pub(crate) fn claim(&self, thread: usize) -> Option<Range<usize>> {
        let threads = self.shares.len();
        (0..threads).find_map(|k| self.take((thread + k) % threads, k == 0))
    }

    /// Takes a quarter of the rest of a share, from its start for its owner and from its end for other threads.
    fn take(&self, share: usize, own: bool) -> Option<Range<usize>> {
        let word = &self.shares[share].0;
        let mut seen = word.load(Ordering::Acquire);
        loop {
            let left = Left::unpack(seen);
            if left.low >= left.high {
                return None;
            }
            let all = left.high - left.low;
            let piece = if self.shares.len() == 1 { all } else { all.div_ceil(4) };
            let (rest, taken) = if own {
                (Left { low: left.low + piece, ..left }, left.low..left.low + piece)
            } else {
                (Left { high: left.high - piece, ..left }, left.high - piece..left.high)
            };
            match word.compare_exchange_weak(seen, rest.pack(), Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => return Some(taken.start as usize..taken.end as usize),
                Err(now) => seen = now,
            }
        }
    }

    /// Reports blocks as done; returns true for the thread that did the last of `all`. No thread works on the stage then,
    /// and none can until the next is opened.
    pub(crate) fn report(&self, blocks: usize, all: usize) -> bool {
        self.done.fetch_add(blocks, Ordering::AcqRel) + blocks == all
    }

    /// Releases all threads.
    pub(crate) fn end(&self) {
        self.over.store(true, Ordering::Release);
    }

    /// Waits for the next stage; returns false if there is none.
    pub(crate) fn wait(&self, thread: usize, turns: &mut u32) -> bool {
        let mine = || Left::unpack(self.shares[thread].0.load(Ordering::Acquire));
        let stage = mine().stage;
        // The stage may have been opened since the last claim failed.
        while mine().stage == stage && mine().low >= mine().high {
            if self.over.load(Ordering::Acquire) {
                return false;
            }
            *turns += 1;
            // On a machine with fewer free cores than threads, further spinning would starve the thread that is waited for.
            if *turns > PATIENCE { std::thread::yield_now() } else { std::hint::spin_loop() }
        }
        *turns = 0;
        true
    }
}

/// Releases the other threads if its thread panics, because they would wait forever.
pub(crate) struct Guard<'a>(pub(crate) &'a Work);

impl Drop for Guard<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.end();
        }
    }
}

/// An array that all threads of a team can access.
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
// SAFETY: the two accessors below are unsafe and state the obligations of their callers.
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
    /// The array that it was made from is alive and has not been moved, and no thread writes to it before the next barrier.
    #[inline(always)]
    pub(crate) unsafe fn read<'a>(&self) -> &'a [T] {
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }

    /// A range for writing.
    ///
    /// # Safety
    /// As for [`RawSlice::read`], and no other thread reads or writes this range before the next barrier.
    #[inline(always)]
    pub(crate) unsafe fn write<'a>(&self, range: Range<usize>) -> &'a mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        unsafe { std::slice::from_raw_parts_mut(self.start.add(range.start), range.end - range.start) }
    }
}

impl<T> RawSlice<T> {
    /// Prefetches the cache line of an element; a hint that reads nothing.
    #[inline(always)]
    pub(crate) fn prefetch(&self, index: usize) {
        granum_simd::prefetch(self.start.wrapping_add(index));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Threads of very different speeds work through stages; every block is done exactly once in each.
    #[test]
    fn every_block_is_done_once_a_stage() {
        const BLOCKS: usize = 37;
        const STAGES: usize = if cfg!(miri) { 20 } else { 400 };
        for threads in [1usize, 2, 3, 7] {
            let work = Work::new(threads);
            let counts: Vec<AtomicUsize> = (0..BLOCKS).map(|_| AtomicUsize::new(0)).collect();
            let stage = AtomicUsize::new(0);
            let share = |t: usize| BLOCKS * t / threads..BLOCKS * (t + 1) / threads;
            work.open(share);
            let run = |thread: usize| {
                let mut turns = 0;
                loop {
                    while let Some(piece) = work.claim(thread) {
                        let now = stage.load(Ordering::SeqCst);
                        for k in piece.clone() {
                            assert_eq!(counts[k].fetch_add(1, Ordering::SeqCst), now);
                        }
                        if thread == 1 && now.is_multiple_of(50) {
                            std::thread::yield_now();
                        }
                        if work.report(piece.len(), BLOCKS) {
                            stage.fetch_add(1, Ordering::SeqCst);
                            if now + 1 == STAGES { work.end() } else { work.open(share) }
                        }
                    }
                    if !work.wait(thread, &mut turns) {
                        return;
                    }
                }
            };
            std::thread::scope(|scope| {
                for thread in 1..threads {
                    scope.spawn(move || run(thread));
                }
                run(0);
            });
            assert!(counts.iter().all(|c| c.load(Ordering::SeqCst) == STAGES));
        }
    }

    #[test]
    fn a_thread_that_panics_lets_the_others_go() {
        let work = Work::new(2);
        let outcome = std::panic::catch_unwind(|| {
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    let _guard = Guard(&work);
                    panic!("on purpose");
                });
                assert!(!work.wait(1, &mut 0));
            });
        });
        assert!(outcome.is_err());
    }
}
