//! Error codes and messages, and the border that no panic crosses.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use granum_point::{PointError, StoreError};

/// Everything is well.
pub const GRANUM_OK: i32 = 0;
/// A pointer is null, a text is no UTF-8, or a number is not possible.
pub const GRANUM_ERROR_ARGUMENT: i32 = 1;
/// A case, a configuration or a file of states cannot be read or written.
pub const GRANUM_ERROR_FILE: i32 = 2;
/// The point gives no answer to an increment or a stress; states are as they were.
pub const GRANUM_ERROR_REFUSED: i32 = 3;
/// There is no such point or ticket.
pub const GRANUM_ERROR_UNKNOWN: i32 = 4;
/// A mistake in granum itself.
pub const GRANUM_ERROR_INTERNAL: i32 = 5;

/// Why a function of the interface failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// An argument is not usable.
    #[error("{0}")]
    Argument(String),
    /// A file is not usable.
    #[error("{path}: {what}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A sample cannot be made.
    #[error("{0}")]
    Sample(String),
    /// A point gives no answer.
    #[error(transparent)]
    Point(#[from] PointError),
    /// A store gives no answer.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl Failure {
    /// Its code in the C interface.
    fn code(&self) -> i32 {
        match self {
            Failure::Argument(_) => GRANUM_ERROR_ARGUMENT,
            Failure::File { .. }
            | Failure::Sample(_)
            | Failure::Point(PointError::Sample(_) | PointError::NoMaterial { .. }) => GRANUM_ERROR_FILE,
            Failure::Store(StoreError::Read { .. } | StoreError::Write(_) | StoreError::File { .. }) => {
                GRANUM_ERROR_FILE
            }
            Failure::Store(StoreError::NoPoint { .. } | StoreError::NoTicket { .. }) => GRANUM_ERROR_UNKNOWN,
            Failure::Point(PointError::Control { .. } | PointError::NoGrains { .. }) => GRANUM_ERROR_ARGUMENT,
            _ => GRANUM_ERROR_REFUSED,
        }
    }
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::new(CString::default());
}

/// The message of the last error of this thread; an empty text if there was none. It is valid until the next call of a function of granum
/// on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn granum_last_error() -> *const c_char {
    MESSAGE.with(|message| message.borrow().as_ptr())
}

/// Keeps a message for [`granum_last_error`].
pub(crate) fn keep_message(text: &str) {
    let text: String = text.chars().filter(|c| *c != '\0').collect();
    MESSAGE.with(|message| *message.borrow_mut() = CString::new(text).unwrap_or_default());
}

/// Does the work of a function of the interface: its error becomes a code and a message, and a panic ends here.
pub(crate) fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> i32 {
    match caught(work) {
        Ok(()) => GRANUM_OK,
        Err((code, message)) => {
            keep_message(&message);
            code
        }
    }
}

/// The result of some work, or the code and the message of its error or panic.
pub(crate) fn caught<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, (i32, String)> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(result)) => Ok(result),
        Ok(Err(failure)) => Err((failure.code(), failure.to_string())),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
            Err((GRANUM_ERROR_INTERNAL, format!("granum has a mistake: {text}; please report it")))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;

    fn last() -> String {
        // SAFETY: the text is valid until the next call.
        unsafe { CStr::from_ptr(granum_last_error()) }.to_str().unwrap().to_string()
    }

    #[test]
    fn a_panic_becomes_a_code_and_a_message() {
        assert_eq!(guarded(|| panic!("index {} is out of bounds", 7)), GRANUM_ERROR_INTERNAL);
        assert!(last().contains("index 7 is out of bounds"));
        assert_eq!(guarded(|| Err(Failure::Argument("it is null".into()))), GRANUM_ERROR_ARGUMENT);
        assert_eq!(last(), "it is null");
        assert_eq!(guarded(|| Ok(())), GRANUM_OK);
        keep_message("a\0b");
        assert_eq!(last(), "ab");
    }
}
