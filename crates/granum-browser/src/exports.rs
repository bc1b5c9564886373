//! What a module exports.

/// Exports the functions by which a page calls a module with these calls, see the documentation of the crate. On processors of another kind it
/// does nothing.
#[macro_export]
macro_rules! export {
    ($calls:expr, takes files: $files:literal) => {
        #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
        mod exported {
            use std::cell::RefCell;

            #[link(wasm_import_module = "page")]
            unsafe extern "C" {
                /// Tells why the module has stopped for good.
                fn panicked(place: *const u8, length: usize);
            }

            struct Exchange {
                page: $crate::Page,
                message: Vec<u8>,
                answer: String,
            }

            thread_local! {
                static EXCHANGE: RefCell<Exchange> = RefCell::new(Exchange {
                    page: $crate::Page::new($calls),
                    message: Vec::new(),
                    answer: String::new(),
                });
            }

            /// Read where files are opened.
            #[unsafe(no_mangle)]
            extern "C" fn granum_takes_files() -> bool {
                $files
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
        }
    };
}
