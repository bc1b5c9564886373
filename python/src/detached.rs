//! Work without Python's lock, whose panics become exceptions.

use std::any::Any;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

use crate::errors;

/// Number of pieces of work that go on. Threads of granum end with the work that began them.
static AT_WORK: AtomicUsize = AtomicUsize::new(0);
/// True in a process that was forked while such work went on: its threads do not exist here, and what they had locked stays so.
static FORKED: AtomicBool = AtomicBool::new(false);

const OF_FORK: &str = "this process was forked while granum was at work in a thread, which does not exist here; start processes with \
                       multiprocessing.get_context(\"spawn\"), which is also the default of newer versions of Python";

/// Python calls it in the child after a fork.
#[pyfunction]
#[pyo3(name = "_forked")]
pub fn forked() {
    if AT_WORK.swap(0, Ordering::Relaxed) > 0 {
        FORKED.store(true, Ordering::Relaxed);
    }
}

/// Where the first interpreter of this process that imported granum has its built-in functions; 0 before.
static INTERPRETER: AtomicUsize = AtomicUsize::new(0);

/// Refuses every interpreter of this process but the first one: what this module keeps would be shared between them.
///
/// # Errors
/// `ImportError` in an interpreter beside the first.
#[pyfunction]
#[pyo3(name = "_entered")]
pub fn entered(py: Python<'_>) -> PyResult<()> {
    let own = py.import("builtins")?.as_ptr().addr();
    match INTERPRETER.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed) {
        Err(first) if first != own => Err(PyImportError::new_err(
            "granum is used by another interpreter of this process and cannot be shared; start a process instead of an interpreter",
        )),
        _ => Ok(()),
    }
}

/// Counts a piece of work as long as it lives.
struct AtWork;

impl AtWork {
    fn new() -> AtWork {
        AT_WORK.fetch_add(1, Ordering::Relaxed);
        AtWork
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        // In a forked process the count begins anew, and the work in which it was forked ends there as well.
        let _ = AT_WORK.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| count.checked_sub(1));
    }
}

/// Does some work while other threads of Python go on. A panic, a mistake of granum, becomes an `InternalError`.
///
/// # Errors
/// In a process that was forked while granum was at work, after a panic, and what [`raise`] was given.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    if FORKED.load(Ordering::Relaxed) {
        return Err(errors::general(py, OF_FORK));
    }
    let at_work = AtWork::new();
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    drop(at_work);
    done.map_err(|panic| match panic.downcast::<Raised>() {
        Ok(raised) => raised.0,
        Err(panic) => errors::internal(py, &message(panic.as_ref())),
    })
}

/// What a function of the user raised inside work that has no errors of its own.
struct Raised(PyErr);

/// Ends the work that [`detached`] began, which then raises what a function of the user did. What the work had begun to change is left
/// as it was when a process is killed.
pub fn raise(error: PyErr) -> ! {
    resume_unwind(Box::new(Raised(error)))
}

/// Where the last panic was; with several at once that of one of them.
static PLACE: Mutex<Option<String>> = Mutex::new(None);

/// Takes the place of the message that a panic prints: what is wrong and where stands in the exception. Panics of other libraries do
/// not come here, since each has a hook of its own.
pub fn note_panic(info: &PanicHookInfo<'_>) {
    *PLACE.lock().unwrap_or_else(PoisonError::into_inner) = info.location().map(ToString::to_string);
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().map(str::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    let text = text.unwrap_or_else(|| "it gave no reason".into());
    let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner).take();
    let place = place.map_or_else(String::new, |place| format!(" at {place}"));
    format!("granum made a mistake ({text}{place}); please report it with the case that shows it")
}
