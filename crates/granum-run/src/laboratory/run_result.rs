//! The result of a run that was kept in memory.

use std::sync::Arc;

use granum_core::ObservedState;
use granum_dem::simulation::Simulation;
use granum_io::RunRecord;
use granum_sensors::Record;

use crate::task::engine_error::EngineError;
use crate::task::laboratory_error::LaboratoryError;

/// The result of a run that was kept in memory.
#[derive(Clone)]
pub struct RunResult {
    /// The measurements of a test: the series of states and the histograms of forces. Empty for a sample.
    pub record: Record,
    /// The record of the run: measures, quality flags, notes, numbers of steps.
    pub about: RunRecord,
    /// The state at the end of the run, which can be observed, from an engine that has it in this process.
    pub state: Option<Arc<dyn ObservedState + Send + Sync>>,
}

impl RunResult {
    /// The simulation at the end of the run, which can be inspected or copied and continued.
    ///
    /// # Errors
    /// [`EngineError::NoSimulation`] if the engine has none in this process, or is not granum's own.
    pub fn simulation(&self) -> Result<&Simulation, LaboratoryError> {
        let engine = || EngineError::NoSimulation { engine: self.about.engine.clone() };
        let state = self.state.as_ref().and_then(|state| state.as_any().downcast_ref());
        state.ok_or_else(|| engine().into())
    }
}
