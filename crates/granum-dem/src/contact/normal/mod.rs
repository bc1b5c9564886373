//! Normal laws, one file each.

pub mod hertz;
pub mod hooke;
pub mod jkr;

pub use hertz::Hertz;
pub use hooke::Hooke;
pub use jkr::Jkr;
