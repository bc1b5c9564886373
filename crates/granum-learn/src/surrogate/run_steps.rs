//! A run whose states come one after the other, for surrogates with memory.

use super::prediction::Prediction;
use super::run_memory::RunMemory;
use crate::error::Result;

/// A run whose states come one after the other: what a surrogate with memory keeps between them. A state is predicted first and accepted then, so that
/// one that cannot be answered leaves no trace. It owns what it needs of the surrogate.
pub trait RunSteps: Send {
    /// The prediction for the next state, with a finite value for every input in order, to the bits of [`Surrogate::evaluate`](super::Surrogate::evaluate) for
    /// the whole run. The memory stays what it was before this state.
    ///
    /// # Errors
    /// If the state cannot be predicted.
    fn predict(&mut self, row: &[f64]) -> Result<Prediction>;

    /// The means of the outputs for each of several possible next states, to the bits of [`RunSteps::predict`] for each of them, as differences of a tangent need them. The
    /// memory stays what it was, and no state can be accepted afterwards before it is predicted.
    ///
    /// # Errors
    /// As [`RunSteps::predict`].
    fn means_of(&mut self, rows: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let means = |row: &Vec<f64>| -> Result<Vec<f64>> {
            Ok(self.predict(row)?.values.iter().map(|estimate| estimate.mean).collect())
        };
        rows.iter().map(means).collect()
    }

    /// The memory after the state that was predicted last becomes that before the next one.
    fn accept(&mut self);

    /// The next state is the first of a new run.
    fn restart(&mut self);

    /// The memory before the next state, as a value.
    fn memory(&self) -> RunMemory;

    /// Goes on from a memory of any run of the same surrogate. The states after it have the bits of those after it in its own run.
    ///
    /// # Errors
    /// If it is not a memory of this surrogate; the next state is then the first of a new run.
    fn resume(&mut self, memory: &RunMemory) -> Result<()>;

    /// The prediction for the state after a memory, and the memory after that state.
    ///
    /// # Errors
    /// As [`RunSteps::resume`] and [`RunSteps::predict`].
    fn step_from(&mut self, memory: &RunMemory, row: &[f64]) -> Result<(RunMemory, Prediction)> {
        self.resume(memory)?;
        let prediction = self.predict(row)?;
        self.accept();
        Ok((self.memory(), prediction))
    }
}
