//! What the module exports.
//!
//! SAFETY: a module of WebAssembly without shared memory has one thread, and its functions are called by a page, one after the other.

use std::cell::RefCell;

use crate::page::Page;

#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Tells why the module has stopped for good.
    fn panicked(place: *const u8, length: usize);
}

#[derive(Default)]
struct Exchange {
    page: Page,
    message: Vec<u8>,
    answer: String,
}

thread_local! {
    static EXCHANGE: RefCell<Exchange> = RefCell::default();
}

/// Makes room for a message of so many bytes, and returns its place.
#[unsafe(no_mangle)]
extern "C" fn message(length: usize) -> *mut u8 {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.message = vec![0; length];
        exchange.message.as_mut_ptr()
    })
}

/// Carries out the message, and returns the length of the answer.
#[unsafe(no_mangle)]
extern "C" fn call() -> usize {
    std::panic::set_hook(Box::new(|why| {
        let text = why.to_string();
        // SAFETY: the page reads the text before the function returns.
        unsafe { panicked(text.as_ptr(), text.len()) };
    }));
    EXCHANGE.with_borrow_mut(|exchange| {
        let message = std::mem::take(&mut exchange.message);
        exchange.answer = exchange.page.answer(&String::from_utf8_lossy(&message));
        exchange.answer.len()
    })
}

/// The place of the answer, which stays until the next call.
#[unsafe(no_mangle)]
extern "C" fn answer() -> *const u8 {
    EXCHANGE.with_borrow(|exchange| exchange.answer.as_ptr())
}
