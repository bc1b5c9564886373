//! Runs in folders, from which they can be resumed.

use granum_dem::observer::Observer;
use granum_io::Case;
use granum_io::run::{RunFolder, RunRecord, TEST};

use super::laboratory_error::LaboratoryError;
use super::source::Source;
use crate::engine::engine_error::EngineError;
use crate::engine::engine_trait::{Engine, Laboratory, PlannedRun, Task};

impl Laboratory {
    /// Prepares a sample and writes it to a folder: case, snapshot, checkpoint, record. The status in the record states
    /// whether the preparation was interrupted.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn prepare(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        self.engine()?.run(Task::new("prepare", case, source, self), folder, observer)
    }

    /// Prepares or reads a sample and tests it as the case specifies; writes a run folder.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn shear(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        self.engine()?.run(Task::new(TEST, case, source, self), folder, observer)
    }

    /// Reads and checks the inputs of a run of a `kind` (`prepare`, `test`), and warns the observer of anything that the
    /// user should know. Nothing is written, so that a mistake leaves no folder behind.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the case does not fit into memory, or if its sample or packing cannot be used.
    pub fn planned<'a>(
        &'a self,
        kind: &'a str,
        case: &'a Case,
        source: &'a Source,
        observer: &mut dyn Observer,
    ) -> Result<PlannedRun<'a>, LaboratoryError> {
        self.engine()?.begin(Task::new(kind, case, source, self), observer)
    }

    /// Resumes a preparation or test that was interrupted, was killed or failed, from its last usable checkpoint, or from
    /// the case if there is no checkpoint yet.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the contents of the folder cannot be used, or if the run fails again.
    pub fn resume(
        &self,
        folder: &RunFolder,
        observer: &mut dyn Observer,
    ) -> Result<RunRecord, LaboratoryError> {
        let engine = folder.run().record()?.engine;
        self.registry.engines.named(&engine)?.resume(self, folder, observer)
    }

    /// The engine that executes cases.
    fn engine(&self) -> Result<&dyn Engine, EngineError> {
        self.registry.engines.named(&self.engine)
    }
}
