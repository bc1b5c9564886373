//! An [`Engine`] computes samples and tests. The engine of granum is [`Native`](native::Native); [`Lammps`] starts another program; a new one needs a
//! file in this folder and a line in [`Engines::standard`], and a program can add its own engine with
//! [`RunRegistry::with_engine`](crate::RunRegistry::with_engine).

mod checks;
pub(crate) mod engine_run;
pub(crate) mod engine_trait;
pub(crate) mod engines;
mod flags;
mod foreseen;
mod lammps;
pub mod native;

pub use crate::task::definition::Task;
pub use crate::task::engine_error::EngineError;
pub use crate::task::resources::{CHECKPOINT_EVERY, GRAINS_PER_THREAD, Resources};
pub use crate::task::sink::Sink;
pub use checks::CHECKS;
pub use engine_run::EngineRun;
pub use engine_trait::Engine;
pub use engines::Engines;
pub use foreseen::{ForeseenFailure, foreseen_failures};
pub use lammps::{LAMMPS, Lammps, LammpsStart};

#[cfg(test)]
mod tests;
