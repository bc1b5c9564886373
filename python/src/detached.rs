//! Work without Python's lock, whose panics become exceptions.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::prelude::*;

use crate::errors;

/// True once work was begun in this process: there may be threads of granum, which a fork would not copy.
static USED: AtomicBool = AtomicBool::new(false);
/// True in a process that was forked from such a one.
static FORKED: AtomicBool = AtomicBool::new(false);

const OF_FORK: &str = "this process was forked from one that had used granum, whose threads do not exist here; start processes \
                       with multiprocessing.get_context(\"spawn\"), which is also the default of newer versions of Python";

/// Python calls it in the child after a fork.
#[pyfunction]
#[pyo3(name = "_forked")]
pub fn forked() {
    FORKED.fetch_or(USED.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// Does some work while other threads of Python go on. A panic, a mistake of granum, becomes an `InternalError`.
///
/// # Errors
/// In a process that was forked from one that had used granum, and after a panic.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    if FORKED.load(Ordering::Relaxed) {
        return Err(errors::general(py, OF_FORK));
    }
    USED.store(true, Ordering::Relaxed);
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|panic| errors::internal(py, &message(panic.as_ref())))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().map(str::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "it gave no reason".into());
    format!("granum made a mistake ({text}); please report it with the case that shows it")
}
