//! Tangential laws, one file each.

pub mod mindlin_deresiewicz;
pub mod no_slip;
pub mod peeling;

pub use mindlin_deresiewicz::MindlinDeresiewicz;
pub use no_slip::NoSlip;
pub use peeling::Peeling;
