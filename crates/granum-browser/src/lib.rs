//! The laboratory and the surrogates in a browser: a module of WebAssembly that a page calls by messages.
//!
//! A message is a JSON object with the name of a call (`"call": "begin"`) and its arguments; the answer is a JSON object, which has a
//! key `error` if the call failed. [`Page::answer`] takes a message and gives the answer, on any processor. There are two modules, so that a
//! page that only shows a test loads no more than it needs: one with the calls [`ENGINE`], one with the calls [`SURROGATES`]
//! (`examples/`). A module exports ([`export!`]):
//!
//! | function | what it does |
//! |---|---|
//! | `message(length)` | makes room for a message of so many bytes, and returns its place |
//! | `call()` | carries out the message, and returns the length of the answer |
//! | `answer()` | the place of the answer, which stays until the next call |
//!
//! It imports two functions of the page: `milliseconds()`, a clock, and `panicked(place, length)`, which is told why the module
//! has stopped for good.

mod answer;
mod calls;
mod exports;
mod pace;
mod page;

pub use calls::{ENGINE, SURROGATES};
pub use page::{Call, Page};
