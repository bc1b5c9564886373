//! Memory as the sink of an engine.

use std::sync::Arc;

use granum_core::ObservedState;
use granum_io::Result;
use granum_io::run::RunRecord;
use granum_sensors::Record;

use crate::task::sink::Sink;

/// Keeps the record, the measurements and the last state of a run that writes no files.
pub(super) struct MemorySink {
    pub(super) about: RunRecord,
    pub(super) measurements: Record,
    pub(super) state: Option<Arc<dyn ObservedState + Send + Sync>>,
}

impl MemorySink {
    pub(super) fn new(about: RunRecord) -> MemorySink {
        MemorySink { about, measurements: Record::default(), state: None }
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
    fn keep(&mut self, state: Arc<dyn ObservedState + Send + Sync>) {
        self.state = Some(state);
    }
}
