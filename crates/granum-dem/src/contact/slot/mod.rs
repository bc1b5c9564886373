//! Laws behind function pointers, so that laws that are chosen at run time, also those of a caller, can be combined at will.

pub mod columns;
pub mod entry;
pub mod slot_traits;
pub mod slots;

mod calls;
