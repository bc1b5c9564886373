//! The task that an engine is given, and what laboratory and engines both know of it: where a sample comes from, where results go, what it
//! needs of time and memory, how far it is, and what can go wrong.

pub(crate) mod definition;
pub(crate) mod engine_error;
pub mod estimate;
pub(crate) mod laboratory_error;
pub mod memory;
pub(crate) mod packing_simulation;
pub(crate) mod resources;
pub(crate) mod saved_run;
pub(crate) mod shared;
pub(crate) mod sink;
pub(crate) mod source;
pub(crate) mod status;
