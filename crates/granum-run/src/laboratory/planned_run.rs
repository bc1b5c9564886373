//! A run whose inputs have been checked, and where its results go.

use granum_dem::observer::SimulationObserver;
use granum_dem::preparation::PreparationError;
use granum_io::Case;
use granum_io::run::{RunFolder, RunRecord, RunSource, RunStatus};

use super::folder_sink::FolderSink;
use super::memory_sink::MemorySink;
use super::run_result::RunResult;
use crate::engine::engine_run::EngineRun;
use crate::task::laboratory_error::LaboratoryError;

/// Beginning of the note of a run that failed.
pub(super) const FAILED: &str = "failed: ";

/// A run whose inputs have been checked and which has not written anything yet.
#[derive(Debug)]
pub struct PlannedRun {
    pub(super) case: Case,
    pub(super) run: EngineRun,
}

impl PlannedRun {
    /// The record with which the run begins.
    pub fn record(&self) -> &RunRecord {
        &self.run.record
    }

    /// Executes the run until its end, or until the observer stops it, and writes its results into a folder. The record is written
    /// first and contains the case until the file of the case has been written, so that the run can be resumed from the first file
    /// on. Only where the sample is in another folder or file the first checkpoint comes before the record: a folder with a record
    /// can be moved alone.
    ///
    /// # Errors
    /// [`LaboratoryError`]; the record in the folder then has the status `failed`.
    pub fn in_folder(
        self,
        folder: &RunFolder,
        observer: &mut dyn SimulationObserver,
    ) -> Result<RunRecord, LaboratoryError> {
        let PlannedRun { case, run } = self;
        let mut record = run.record.clone();
        record.unwritten_case = Some(case.resolved_toml());
        if run.saves_first() && record.source != RunSource::Case {
            return finish(folder, record, |record| {
                run.run(&mut FolderSink::with_checkpoint_first(folder, record, &case), observer)
            });
        }
        folder.write_record(&record)?;
        write_case(folder, &case, &record)?;
        record.unwritten_case = None;
        finish(folder, record, |record| run.run(&mut FolderSink::new(folder, record), observer))
    }

    /// Executes the run until its end, or until the observer stops it: the status in the record says which. No files are written;
    /// the results are identical bit by bit to those of [`PlannedRun::in_folder`].
    ///
    /// # Errors
    /// [`LaboratoryError`] if the run fails.
    pub fn in_memory(self, observer: &mut dyn SimulationObserver) -> Result<RunResult, LaboratoryError> {
        let mut sink = MemorySink::new(self.run.record.clone());
        self.run.run(&mut sink, observer)?;
        let MemorySink { mut about, measurements, state } = sink;
        if about.status == RunStatus::Running {
            about.status = RunStatus::Finished;
        }
        Ok(RunResult { record: measurements, about, state })
    }
}

/// Writes the case; if a packing takes the place of the random insertion, the file names it.
pub(super) fn write_case(folder: &RunFolder, case: &Case, record: &RunRecord) -> Result<(), LaboratoryError> {
    let packing = record.packing.as_ref().map(|packing| packing.file_name.as_str());
    Ok(folder.write_case(case, packing)?)
}

/// Calls `work` and writes the record with the resulting status.
pub(super) fn finish(
    folder: &RunFolder,
    mut record: RunRecord,
    work: impl FnOnce(&mut RunRecord) -> Result<(), LaboratoryError>,
) -> Result<RunRecord, LaboratoryError> {
    let result = match work(&mut record).and_then(|()| Ok(folder.check_present()?)) {
        // Grains were being placed again: there is no state yet, and `resume` starts from the case.
        Err(LaboratoryError::Preparation(PreparationError::Stopped { .. })) => {
            record.status = RunStatus::Interrupted;
            Ok(())
        }
        result => result,
    };
    match &result {
        Ok(()) if record.status == RunStatus::Running => record.status = RunStatus::Finished,
        Ok(()) => {}
        Err(error) => {
            record.status = RunStatus::Failed;
            record.notes.push(format!("{FAILED}{error}"));
        }
    }
    // The tables now have every state. After a failure they may not, and what was recorded since stays to be looked at.
    let removed = if result.is_ok() { folder.remove_states() } else { Ok(()) };
    let written = folder.write_record(&record);
    // If several fail, as on a full disk, the first error is reported.
    result?;
    removed?;
    written?;
    Ok(record)
}
