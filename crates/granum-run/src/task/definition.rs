//! The task of an engine.

use granum_io::case::Vocabulary;
use granum_io::run::{Machine, RunKind, RunRecord};
use granum_io::{Case, Formats};

use super::resources::Resources;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::source::Source;

/// The task of an engine: what to compute, and with what.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Task {
    /// What to do: to make a sample, or to test one.
    pub kind: RunKind,
    /// The case, which determines the result.
    pub case: Case,
    /// The source of the sample.
    pub source: Source,
    /// Name of the engine, for the record.
    pub engine: String,
    /// Version of granum, for the record.
    pub version: String,
    /// What the run may use of the computer. It does not influence the result.
    pub resources: Resources,
    /// The laws, paths and sensors that the case can name.
    pub vocabulary: Vocabulary,
    /// The formats by which packings are read.
    pub formats: Formats,
}

impl Task {
    /// The initial record of a run of this task.
    ///
    /// # Errors
    /// If the file of the sample cannot be read.
    pub fn record(&self) -> Result<RunRecord, LaboratoryError> {
        let hardware = &self.resources.hardware;
        let machine = Machine::here(hardware.isa.name(), hardware.threads);
        let mut record = RunRecord::new(self.kind, &self.version, &self.case, machine);
        record.engine.clone_from(&self.engine);
        record.source = self.source.record()?;
        Ok(record)
    }
}
