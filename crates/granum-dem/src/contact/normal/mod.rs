//! Normal laws, one file each.

pub mod dmt;
pub mod hertz;
pub mod hooke;
pub mod jkr;
pub mod jkr_dmt;
pub mod luding;
pub mod rough_hertz;

pub use dmt::Dmt;
pub use hertz::Hertz;
pub use hooke::Hooke;
pub use jkr::Jkr;
pub use jkr_dmt::JkrDmt;
pub use luding::Luding;
pub use rough_hertz::RoughHertz;
