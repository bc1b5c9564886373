//! The execution of one run of a queue: a finished one is used again, an unfinished one continues, and otherwise a new one begins.

use std::panic::{AssertUnwindSafe, catch_unwind};

use granum_dem::observer::SimulationObserver;
use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT, file_digest};
use granum_io::{Run, RunFolder, RunRecord, RunSource, RunStatus};

use super::outcome::RunError;
use super::queue_error::QueueError;
use super::queued_run::QueuedRun;
use crate::laboratory::definition::Laboratory;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::source::Source;

/// What the folder of a planned run holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Held {
    /// No run.
    Nothing,
    /// The planned run, finished.
    Finished(Box<RunRecord>),
    /// The planned run, not finished or not whole.
    Unfinished(Box<RunRecord>),
    /// A run of another case or version.
    Other(Box<RunRecord>),
}

impl Held {
    /// Looks into the folder of a run.
    ///
    /// # Errors
    /// If there is a record that cannot be read, or the packing of the run cannot be read.
    pub(super) fn by(run: &QueuedRun, laboratory: &Laboratory) -> granum_io::Result<Held> {
        Held::found(run, laboratory, |held| held.faults().is_ok_and(|faults| faults.is_empty()))
    }

    /// The same by the record alone: a finished run counts as whole.
    pub(super) fn by_record(run: &QueuedRun, laboratory: &Laboratory) -> granum_io::Result<Held> {
        Held::found(run, laboratory, |_| true)
    }

    fn found(
        run: &QueuedRun,
        laboratory: &Laboratory,
        is_whole: impl FnOnce(&Run) -> bool,
    ) -> granum_io::Result<Held> {
        if !run.folder.join("run.json").is_file() {
            return Ok(Held::Nothing);
        }
        let held = Run::at(&run.folder)?.with_vocabulary(&run.case.vocabulary);
        let record = Box::new(held.record()?);
        Ok(match (is_of(&record, run, laboratory)?, record.status) {
            (false, _) => Held::Other(record),
            // A finished run of which a file was changed or removed is not used again as it is.
            (true, RunStatus::Finished) if is_whole(&held) => Held::Finished(record),
            (true, _) => Held::Unfinished(record),
        })
    }

    /// True if the run needs the sample of another run.
    pub(super) fn needs_sample(&self) -> bool {
        match self {
            Held::Finished(_) => false,
            Held::Unfinished(record) => record.source != RunSource::Case,
            Held::Nothing | Held::Other(_) => true,
        }
    }
}

/// True if a record, finished or not, is that of a planned run with this version.
fn is_of(record: &RunRecord, run: &QueuedRun, laboratory: &Laboratory) -> granum_io::Result<bool> {
    let packing = match &run.source {
        Source::Case => None,
        Source::Packing(file) => Some(file_digest(file)?),
        Source::Folder(folder) => {
            let sample = Run::at(folder).and_then(|sample| sample.record()).ok();
            sample.and_then(|sample| sample.packing_digest().map(str::to_string))
        }
    };
    // A run that has been prepared only in part does not always know its packing yet.
    let same_case = record.case_digest == run.case.digest_with(packing.as_deref());
    Ok(same_case
        && record.kind == run.kind
        && laboratory.engine_for(run.kind).is_ok_and(|engine| record.engine == engine)
        && record.granum_version == laboratory.version)
}

/// Refuses the folder of a run if it is a link, or holds another run that is not to be replaced.
pub(super) fn check_folder(
    run: &QueuedRun,
    laboratory: &Laboratory,
    replace_others: bool,
) -> Result<Held, QueueError> {
    if std::fs::symlink_metadata(&run.folder).is_ok_and(|kind| kind.is_symlink()) {
        let message =
            "is a symbolic link; a run must stay in its folder, so replace it by a folder or remove it";
        return Err(granum_io::Error::content(&run.folder, message).into());
    }
    match Held::by_record(run, laboratory) {
        Err(_) if replace_others => Ok(Held::Nothing),
        Err(error) => Err(error.into()),
        Ok(Held::Other(record)) if !replace_others => {
            let (folder, version) = (run.folder.clone(), record.granum_version);
            Err(QueueError::OtherRun { folder, version })
        }
        Ok(held) => Ok(held),
    }
}

/// Executes a run; a panic is an error of this run alone.
pub(super) fn execute(
    laboratory: &Laboratory,
    run: &QueuedRun,
    observer: &mut dyn SimulationObserver,
) -> Result<RunRecord, RunError> {
    catch_unwind(AssertUnwindSafe(|| go_on(laboratory, run, observer))).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(RunError::Panic(text.to_string()))
    })
}

fn has_lost_its_sample(run: &QueuedRun, record: &RunRecord) -> bool {
    let is_there = match &record.source {
        RunSource::Case => true,
        RunSource::Sample(folder) => folder.is_dir(),
        RunSource::Packing { file, .. } => file.is_file(),
    };
    !is_there && [CHECKPOINT, PREVIOUS_CHECKPOINT].iter().all(|name| !run.folder.join(name).exists())
}

fn go_on(
    laboratory: &Laboratory,
    run: &QueuedRun,
    observer: &mut dyn SimulationObserver,
) -> Result<RunRecord, RunError> {
    match Held::by(run, laboratory) {
        Ok(Held::Finished(record)) => return Ok(*record),
        // A run that has nothing yet to go on from, nor the sample that its record names, begins again with the planned sample.
        Ok(Held::Unfinished(record)) if has_lost_its_sample(run, &record) => {}
        Ok(Held::Unfinished(_)) => {
            let folder = RunFolder::open(&run.folder)?;
            match laboratory.resume(&folder, observer) {
                // After damage to a file the run is repeated, which costs time but no other run.
                Err(
                    error @ (LaboratoryError::Checkpoint { .. }
                    | LaboratoryError::Unusable { .. }
                    | LaboratoryError::Damaged { .. }),
                ) => observer.warn(&format!("{error}; it is run again here")),
                other => return Ok(other?),
            }
        }
        // What the folder holds has been checked, or may be replaced.
        Ok(Held::Nothing | Held::Other(_)) | Err(_) => {}
    }
    let folder = RunFolder::create(&run.folder, true)?;
    Ok(laboratory.run(run.kind, &run.case, &run.source, &folder, observer)?)
}
