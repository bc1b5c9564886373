//! Containment of panics of an external decoder, which panics where a damaged file should give an error.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// True while this thread reads a file with an external decoder whose panics are converted to errors. A library sets no
/// panic hook; a program that does not want such panics to be printed can query this in its own hook.
pub fn is_contained() -> bool {
    CONTAINED.try_with(Cell::get).unwrap_or(false)
}

/// Runs `work`; returns `None` if it panicked, from which the caller makes an error. Only for work that leaves no
/// inconsistent state behind.
pub(crate) fn contain<T>(work: impl FnOnce() -> T) -> Option<T> {
    let outer = CONTAINED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    CONTAINED.set(outer);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_nothing_and_a_result_passes() {
        assert_eq!(contain(|| 3), Some(3));
        assert_eq!(contain(|| if true { panic!("held") } else { 3 }), None);
        assert!(!CONTAINED.get());
    }
}
