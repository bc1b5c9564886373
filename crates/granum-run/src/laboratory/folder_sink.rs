//! The folder of a run as the sink of an engine.

use std::io::{Result as IoResult, Write};
use std::path::Path;

use granum_core::{Assembly, Table};
use granum_io::Result;
use granum_io::run::{RunFolder, RunRecord};
use granum_sensors::{Record, RecordedState};

use crate::engine::sink::Sink;
use crate::record::write_record;

/// Writes what an engine finds into the folder of a run.
pub(super) struct FolderSink<'a> {
    folder: &'a RunFolder,
    record: &'a mut RunRecord,
}

impl<'a> FolderSink<'a> {
    pub(super) fn new(folder: &'a RunFolder, record: &'a mut RunRecord) -> FolderSink<'a> {
        FolderSink { folder, record }
    }
}

impl Sink for FolderSink<'_> {
    fn record(&mut self) -> &mut RunRecord {
        self.record
    }
    fn save_record(&mut self) -> Result<()> {
        self.folder.write_record(self.record)
    }
    fn begin_states(&mut self, states: &[RecordedState]) -> Result<()> {
        self.folder.write_states(states)
    }
    fn add_state(&mut self, state: &RecordedState) -> Result<()> {
        self.folder.append_state(state)
    }
    fn save_measurements(&mut self, record: &Record) -> Result<()> {
        write_record(self.folder, record)
    }
    fn save_preparation(&mut self, history: &Table) -> Result<()> {
        self.folder.write_preparation(history)
    }
    fn save_snapshot(&mut self, name: &str, assembly: &Assembly) -> Result<()> {
        self.folder.write_snapshot(name, assembly)
    }
    fn save_checkpoint(&mut self, write: &mut dyn FnMut(&mut dyn Write) -> IoResult<()>) -> Result<()> {
        self.folder.write_checkpoint(write)
    }
    fn folder(&self) -> Option<&Path> {
        Some(self.folder.path())
    }
}
