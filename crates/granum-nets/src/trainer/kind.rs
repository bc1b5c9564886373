//! The entries of the registry of trainers.

use super::options::Options;
use super::trainer_trait::SharedTrainer;

/// An entry of the registry: a name, and the function that creates the trainer from options.
#[derive(Clone, Copy, Debug)]
pub struct TrainerKind {
    /// Its name in commands and records.
    pub name: &'static str,
    /// A short description.
    pub help: &'static str,
    /// Creates the trainer.
    pub make: fn(&Options) -> SharedTrainer,
}
