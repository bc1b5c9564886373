//! The result of a run that was kept in memory.

use granum_dem::simulation::Simulation;
use granum_io::RunRecord;
use granum_sensors::Record;

use super::laboratory_error::LaboratoryError;
use crate::engine::engine_error::EngineError;

/// The result of a run that was kept in memory.
#[derive(Clone)]
pub struct RunResult {
    /// The measurements of a test: the series of states and the histograms of forces. Empty for a sample.
    pub record: Record,
    /// The record of the run: measures, quality flags, notes, numbers of steps.
    pub about: RunRecord,
    /// The simulation at the end of the run, which can be inspected or continued, from an engine that has one in this process.
    pub simulation: Option<Simulation>,
}

impl RunResult {
    /// The simulation at the end of the run.
    ///
    /// # Errors
    /// [`EngineError::NoSimulation`] if the engine has none in this process.
    pub fn simulation(&self) -> Result<&Simulation, LaboratoryError> {
        let engine = || EngineError::NoSimulation { engine: self.about.engine.clone() };
        self.simulation.as_ref().ok_or_else(|| engine().into())
    }
}
