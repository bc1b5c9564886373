//! Memory as the sink of an engine.

use granum_dem::simulation::Simulation;
use granum_io::Result;
use granum_io::run::RunRecord;
use granum_sensors::Record;

use crate::engine::sink::Sink;

/// Keeps the record, the measurements and the simulation of a run that writes no files.
pub(super) struct MemorySink {
    pub(super) about: RunRecord,
    pub(super) measurements: Record,
    pub(super) simulation: Option<Simulation>,
}

impl MemorySink {
    pub(super) fn new(about: RunRecord) -> MemorySink {
        MemorySink { about, measurements: Record::default(), simulation: None }
    }
}

impl Sink for MemorySink {
    fn record(&mut self) -> &mut RunRecord {
        &mut self.about
    }
    fn save_measurements(&mut self, record: &Record) -> Result<()> {
        self.measurements = record.clone();
        Ok(())
    }
    fn keep(&mut self, simulation: Simulation) {
        self.simulation = Some(simulation);
    }
}
