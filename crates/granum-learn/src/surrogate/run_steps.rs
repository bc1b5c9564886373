//! A run whose states come one after the other, for surrogates with memory.

use super::prediction::Prediction;
use crate::error::Result;

/// A run whose states come one after the other: what a surrogate with memory keeps between them. A state is predicted first and accepted then, so that
/// one that cannot be answered leaves no trace.
pub trait RunSteps: Send {
    /// The prediction for the next state, with a finite value for every input in order, to the bits of [`Surrogate::evaluate`](super::Surrogate::evaluate) for
    /// the whole run. The memory stays what it was before this state.
    ///
    /// # Errors
    /// If the state cannot be predicted.
    fn predict(&mut self, row: &[f64]) -> Result<Prediction>;

    /// The memory after the state that was predicted last becomes that before the next one.
    fn accept(&mut self);

    /// The next state is the first of a new run.
    fn restart(&mut self);
}
