//! Handles, and how pointers of the caller are read and written.

use std::ffi::{CStr, c_char};
use std::sync::Arc;

use granum_point::{MaterialPoint, State, Store};

use crate::failure::Failure;

/// A material point: a sample, and how it is strained. It can be used from any number of threads at the same time.
pub struct GranumPoint(pub(crate) Arc<MaterialPoint>);

/// A state of a material point. It is never changed, and can be used from any number of threads at the same time.
pub struct GranumState(pub(crate) State);

/// The states of many points under tickets. It can be used from any number of threads at the same time.
pub struct GranumStore(pub(crate) Store);

/// What a pointer points to.
///
/// # Safety
/// The pointer is null or valid.
pub(crate) unsafe fn reference<'a, T>(pointer: *const T, what: &str) -> Result<&'a T, Failure> {
    // SAFETY: as the caller promises.
    unsafe { pointer.as_ref() }.ok_or_else(|| Failure::Argument(format!("the {what} is a null pointer")))
}

/// Writes a value where a pointer points to.
///
/// # Safety
/// The pointer is null or valid.
pub(crate) unsafe fn write<T>(pointer: *mut T, value: T, what: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::Argument(format!("the place for the {what} is a null pointer")));
    }
    // SAFETY: as the caller promises.
    unsafe { pointer.write(value) };
    Ok(())
}

/// A list of `N` numbers.
///
/// # Safety
/// The pointer is null or valid for `N` numbers.
pub(crate) unsafe fn numbers<const N: usize>(pointer: *const f64, what: &str) -> Result<[f64; N], Failure> {
    // SAFETY: as the caller promises; an array has no stricter alignment than its entries.
    unsafe { reference(pointer.cast::<[f64; N]>(), what) }.copied()
}

/// A text of C.
///
/// # Safety
/// The pointer is null or a text that ends with a zero.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(Failure::Argument(format!("the {what} is a null pointer")));
    }
    // SAFETY: as the caller promises.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Failure::Argument(format!("the {what} is not UTF-8")))
}

/// A handle for a value.
pub(crate) fn handle<T>(value: T) -> *mut T {
    Box::into_raw(Box::new(value))
}

/// Frees a handle; null is nothing.
///
/// # Safety
/// The pointer is null or a handle that was not freed before.
pub(crate) unsafe fn free<T>(pointer: *mut T) {
    if !pointer.is_null() {
        // SAFETY: as the caller promises.
        drop(unsafe { Box::from_raw(pointer) });
    }
}
