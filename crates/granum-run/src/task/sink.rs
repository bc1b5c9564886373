//! Where an engine puts what it finds.

use std::io::{Result as IoResult, Write};
use std::path::Path;
use std::sync::Arc;

use granum_core::{Assembly, ObservedState, Table};
use granum_io::Result;
use granum_io::run::RunRecord;
use granum_sensors::{Record, RecordedState};

/// Where an engine puts what it finds: the folder of a run, or memory. A sink takes over what it needs; most methods do nothing
/// unless it implements them.
pub trait Sink {
    /// The record of the run, which the engine completes: measures, quality flags, notes, steps, times. Its status is
    /// [`RunStatus::Running`](granum_io::RunStatus::Running) until the run has ended or the engine sets another one.
    fn record(&mut self) -> &mut RunRecord;

    /// Saves the record as it is now.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save_record(&mut self) -> Result<()> {
        Ok(())
    }

    /// Begins a test, or continues it after these states: those that are recorded from now on follow them.
    ///
    /// # Errors
    /// If they cannot be written.
    fn begin_states(&mut self, states: &[RecordedState]) -> Result<()> {
        let _ = states;
        Ok(())
    }

    /// A state was recorded. Whoever follows the run sees it at once.
    ///
    /// # Errors
    /// If it cannot be written.
    fn add_state(&mut self, state: &RecordedState) -> Result<()> {
        let _ = state;
        Ok(())
    }

    /// The measurements of a test so far, all states with their histograms; they replace those given before.
    ///
    /// # Errors
    /// If they cannot be written.
    fn save_measurements(&mut self, record: &Record) -> Result<()> {
        let _ = record;
        Ok(())
    }

    /// The history of the preparation so far; it replaces the one given before.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save_preparation(&mut self, history: &Table) -> Result<()> {
        let _ = history;
        Ok(())
    }

    /// All grains and contacts at one instant: [`SAMPLE`](crate::engine::native::SAMPLE) at the start of a test,
    /// [`END`](crate::engine::native::END) at its end.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save_snapshot(&mut self, name: &str, assembly: &Assembly) -> Result<()> {
        let _ = (name, assembly);
        Ok(())
    }

    /// The state from which the run can be resumed, which `write` writes. The one before is kept until the next.
    ///
    /// # Errors
    /// If it cannot be written.
    fn save_checkpoint(&mut self, write: &mut dyn FnMut(&mut dyn Write) -> IoResult<()>) -> Result<()> {
        let _ = write;
        Ok(())
    }

    /// The folder of the run, in which an engine can keep restart files of its own; `None` for a run that writes no files.
    fn folder(&self) -> Option<&Path> {
        None
    }

    /// The state at the end of the run, from an engine that has it in this process: granum's own gives its simulation.
    fn keep(&mut self, state: Arc<dyn ObservedState + Send + Sync>) {
        drop(state);
    }
}
