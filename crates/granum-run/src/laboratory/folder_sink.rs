//! The folder of a run as the sink of an engine.

use std::io::{Result as IoResult, Write};
use std::path::Path;

use granum_core::{Assembly, Table};
use granum_io::run::{RunFolder, RunRecord};
use granum_io::{Case, Result};
use granum_sensors::{Record, RecordedState};

use crate::record::write_record;
use crate::task::sink::Sink;

/// Writes what an engine finds into the folder of a run.
pub(super) struct FolderSink<'a> {
    folder: &'a RunFolder,
    record: &'a mut RunRecord,
    /// The case of a run whose record and case wait for its first checkpoint.
    waiting: Option<&'a Case>,
}

impl<'a> FolderSink<'a> {
    /// The folder of a run whose record and case have been written.
    pub(super) fn new(folder: &'a RunFolder, record: &'a mut RunRecord) -> FolderSink<'a> {
        FolderSink { folder, record, waiting: None }
    }

    /// The folder of a new run, whose record and case are written after its first checkpoint.
    pub(super) fn with_checkpoint_first(
        folder: &'a RunFolder,
        record: &'a mut RunRecord,
        case: &'a Case,
    ) -> FolderSink<'a> {
        FolderSink { folder, record, waiting: Some(case) }
    }

    /// Writes record and case, if they have waited.
    fn begin(&mut self) -> Result<()> {
        let Some(case) = self.waiting.take() else { return Ok(()) };
        self.folder.write_record(self.record)?;
        let packing = self.record.packing.as_ref().map(|packing| packing.file_name.as_str());
        self.folder.write_case(case, packing)?;
        self.record.unwritten_case = None;
        Ok(())
    }
}

impl Sink for FolderSink<'_> {
    fn record(&mut self) -> &mut RunRecord {
        self.record
    }
    fn save_record(&mut self) -> Result<()> {
        self.begin()?;
        self.folder.write_record(self.record)
    }
    fn begin_states(&mut self, states: &[RecordedState]) -> Result<()> {
        self.begin()?;
        self.folder.write_states(states)
    }
    fn add_state(&mut self, state: &RecordedState) -> Result<()> {
        self.begin()?;
        self.folder.append_state(state)
    }
    fn save_measurements(&mut self, record: &Record) -> Result<()> {
        self.begin()?;
        write_record(self.folder, record)
    }
    fn save_preparation(&mut self, history: &Table) -> Result<()> {
        self.begin()?;
        self.folder.write_preparation(history)
    }
    fn save_snapshot(&mut self, name: &str, assembly: &Assembly) -> Result<()> {
        self.begin()?;
        self.folder.write_snapshot(name, assembly)
    }
    fn save_checkpoint(&mut self, write: &mut dyn FnMut(&mut dyn Write) -> IoResult<()>) -> Result<()> {
        if self.waiting.is_none() {
            return self.folder.write_checkpoint(write);
        }
        let folder = self.folder;
        // A run that this one replaces stays until all three are there.
        folder.as_one(|| {
            folder.write_checkpoint(write)?;
            self.begin()
        })
    }
    fn folder(&self) -> Option<&Path> {
        Some(self.folder.path())
    }
}
