//! Holding panics of a foreign decoder, which asserts where a damaged file should be an error.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`; `None` if it panicked. Nothing is printed, as the caller makes an error of it.
///
/// Only for work that leaves nothing half-changed behind. The first call puts a hook before the process's panic
/// hook that passes on every panic from elsewhere.
pub(crate) fn contain<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !CONTAINED.try_with(Cell::get).unwrap_or(false) {
                before(info);
            }
        }));
    });
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
