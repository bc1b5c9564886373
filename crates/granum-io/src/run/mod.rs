//! The folder of a run: `case.toml` (resolved), `series.parquet`, `forces.parquet`, `snapshots/`, and `run.json`
//! ([`RunRecord`]). It contains everything that is needed to measure, train or plot again.

mod check;
mod content;
mod file_digest;
mod record;
mod removal;
mod run_folder;
mod source;
mod stage_end;
mod states;
mod times;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use granum_core::assembly::Assembly;
use granum_core::parallel;

use crate::aside;
use crate::case::{Case, Reading, Vocabulary};
use crate::error::{Error, Result};
use crate::folder::{OutputFolder, check_name};
use crate::format::{check_format, damaged};
use crate::sealed::{unseal, unseal_strictly};
use crate::shell::ShowPath;
use crate::snapshot;
use granum_core::Table;
use granum_sensors::force_distribution::FORCES as FORCE_HISTOGRAM;
use granum_sensors::{Record, RecordedState};

use self::states::STATES;

use self::content::{FORCES, HISTOGRAMS, PREPARATION, SERIES, SNAPSHOTS};

pub use check::FileFault;
pub(crate) use content::CASE;
pub use content::{CHECKPOINT, PREVIOUS_CHECKPOINT, REFUSED_CHECKPOINT};
pub(crate) use file_digest::RECORD;
pub use file_digest::file_digest;
pub use run_folder::RunFolder;

pub use stage_end::StageEndRecord;

pub use record::{
    Machine, OWN_ENGINE, PackingRecord, QualityFlag, RUN_FORMAT, RunKind, RunRecord, RunStatus, TEST,
    nulls_are_nan,
};
pub use source::RunSource;

/// Size of the files of a run, bytes, from which on several threads compare them.
const MUCH_TO_READ: u64 = 1 << 24;

/// How often, and how long each time, a reader waits for a file that a running process is just replacing.
const WAITS: (usize, Duration) = (5, Duration::from_millis(20));

/// The folder of a run, for reading; nothing is locked or changed.
///
/// Each file that is read is first compared, once, with its SHA-256 in the record. Before a snapshot is read the tables are
/// compared as well, so that whatever is read belongs to one run.
#[derive(Clone, Debug)]
pub struct Run {
    path: PathBuf,
    /// Names of the files that have been compared.
    compared: Arc<Mutex<BTreeSet<String>>>,
    /// The states that a test under way has recorded, once they have been read.
    states: Arc<Mutex<Option<Arc<Vec<RecordedState>>>>>,
    /// The laws, paths and sensors that the case can name.
    vocabulary: Vocabulary,
}

impl PartialEq for Run {
    fn eq(&self, other: &Run) -> bool {
        self.path == other.path
    }
}

impl Run {
    /// The run in a folder.
    ///
    /// # Errors
    /// [`Error::Content`] if there is no such folder, or it does not contain a run.
    pub fn at(path: impl AsRef<Path>) -> Result<Run> {
        let path = path.as_ref();
        if !path.is_dir() {
            return Err(Error::content(path, "there is no such folder"));
        }
        if !path.join(RECORD).is_file() && aside::is_pending(path) {
            let message = format!(
                "the replacement of its run was cut short; `granum resume {}` puts the run back",
                crate::shell::quoted_path(path)
            );
            return Err(Error::content(path, message));
        }
        if !path.join(RECORD).is_file() && !path.join(CASE).is_file() {
            return Err(Error::content(path, format!("contains no run: neither {RECORD} nor {CASE} exists")));
        }
        Ok(Run::in_folder(path))
    }

    /// The run whose folder of snapshots this is, if it is one.
    pub(crate) fn of_snapshots(run: &Path, snapshots: &Path) -> Option<Run> {
        let run = if run.as_os_str().is_empty() { Path::new(".") } else { run };
        let is_its =
            snapshots.file_name().is_some_and(|name| name == SNAPSHOTS) && run.join(RECORD).is_file();
        is_its.then(|| Run::in_folder(run))
    }

    fn in_folder(path: &Path) -> Run {
        Run {
            path: path.to_path_buf(),
            compared: Arc::default(),
            states: Arc::default(),
            vocabulary: Vocabulary::standard(),
        }
    }

    /// The same run, whose case can name other laws and paths than those of granum.
    pub fn with_vocabulary(self, vocabulary: &Vocabulary) -> Run {
        Run { vocabulary: vocabulary.clone(), ..self }
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The resolved case, which must be that of the record.
    ///
    /// # Errors
    /// As for [`Case::read`]; [`Error::Content`] if the case was changed since the run began.
    pub fn case(&self) -> Result<Case> {
        let path = self.path.join(CASE);
        let record = self.record().ok();
        let pending = record.as_ref().and_then(|record| record.unwritten_case.as_ref());
        let reading = Reading::recorded().with_vocabulary(&self.vocabulary);
        let case = match pending.filter(|_| !path.is_file()) {
            Some(text) => Case::parse_as(text, &path.shown(), reading)?,
            None => Case::read_as(&path, reading)?,
        };
        if record.is_some_and(|record| record.lists_all() && !record.is_of(&case)) {
            let message = "the case was changed since the run began; run the changed case in another folder";
            return Err(Error::content(&path, message));
        }
        Ok(case)
    }

    /// Every file that is not the one that the run wrote, or is missing; empty if the folder is whole. All files are read.
    ///
    /// # Errors
    /// As [`Run::record`] and [`Run::case`]; [`Error::File`] if a file cannot be read.
    pub fn faults(&self) -> Result<Vec<FileFault>> {
        self.case()?;
        let record = self.record()?;
        let mut names: Vec<&str> = record.content.keys().map(String::as_str).collect();
        names.extend(content::TABLES.into_iter().filter(|name| !record.content.contains_key(*name)));
        // Threads are worth their start where there is much to read.
        let size = |name: &&str| self.path.join(name).metadata().map_or(0, |file| file.len());
        let threads = if names.iter().map(size).sum::<u64>() < MUCH_TO_READ { 1 } else { 0 };
        let faults = parallel::map(names.len(), threads, |k| check::fault(&self.path, &record, names[k]))?;
        // Whatever reads the run next through this value need not compare the files again.
        let whole = names.iter().zip(&faults).filter(|(_, fault)| fault.is_none());
        self.compared_names().extend(whole.map(|(name, _)| name.to_string()));
        Ok(faults.into_iter().flatten().collect())
    }

    /// The files that cannot be checked, since the record was written by an earlier version and has no SHA-256 of them.
    ///
    /// # Errors
    /// As [`Run::record`].
    pub fn uncheckable(&self) -> Result<Vec<String>> {
        let record = self.record()?;
        if record.lists_all() {
            return Ok(Vec::new());
        }
        let snapshots = content::usual_snapshots(&self.path);
        let mut names: Vec<String> =
            snapshots.iter().flat_map(|name| content::snapshot_files(name)).collect();
        names.extend(
            content::TABLES.map(String::from).into_iter().filter(|name| self.path.join(name).is_file()),
        );
        names.retain(|name| !record.content.contains_key(name));
        Ok(names)
    }

    /// Compares the tables of the run with the record, and sees to it that no file is missing.
    ///
    /// # Errors
    /// [`Error::Content`] with the name of the first file that was changed, exchanged or removed.
    pub fn check_tables(&self) -> Result<()> {
        let record = self.record()?;
        for name in record.content.keys().map(String::as_str).chain(content::TABLES) {
            if !content::is_of_snapshot(name) || !self.path.join(name).is_file() {
                self.compared(name)?;
            }
        }
        Ok(())
    }

    fn compared_names(&self) -> MutexGuard<'_, BTreeSet<String>> {
        self.compared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The path of a file after it was compared with the record.
    fn compared(&self, name: &str) -> Result<PathBuf> {
        let path = self.path.join(name);
        let mut compared = self.compared_names();
        if compared.contains(name) {
            return Ok(path);
        }
        for left in (0..WAITS.0).rev() {
            match check::fault(&self.path, &self.record()?, name)? {
                None => break,
                Some(_) if left > 0 && OutputFolder::is_in_use(&self.path) => std::thread::sleep(WAITS.1),
                Some(fault) => return Err(fault.error()),
            }
        }
        compared.insert(name.to_string());
        Ok(path)
    }

    /// Reads a table after it was compared with the record.
    fn table(&self, name: &str) -> Result<Table> {
        crate::formats::parquet::read(&self.compared(name)?, None)
    }

    /// True if the run has, or should have, a file of this name.
    fn has(&self, name: &str) -> bool {
        self.path.join(name).is_file()
            || self
                .record()
                .is_ok_and(|record| check::fault(&self.path, &record, name).is_ok_and(|f| f.is_some()))
    }

    /// The error of a folder without a record.
    fn no_record(&self, record: &Path) -> Error {
        if record.symlink_metadata().is_ok() {
            return Error::content(record, "is not a regular file; put the record of the run back");
        }
        let (what, remedy) = if self.path.join(CASE).is_file() {
            ("a case but no", "the run was ended before it started, or the file was removed")
        } else {
            ("no", "the file that tells what the folder is (of a training: training.json) was removed")
        };
        Error::content(
            &self.path,
            format!(
                "holds {what} {RECORD}: {remedy}; put it back, or repeat the command that made it, with --force"
            ),
        )
    }

    /// The record. The origin of its sample is named as it is found from here.
    ///
    /// # Errors
    /// If `run.json` is missing, damaged or of a newer version.
    pub fn record(&self) -> Result<RunRecord> {
        let path = self.path.join(RECORD);
        if !path.is_file() {
            return Err(self.no_record(&path));
        }
        let text = crate::text::read_small(&path, 1 << 24)?;
        let format = check_format(&path, &text, RUN_FORMAT)?;
        let text = if format < 2 { unseal(&path, &text)?.text } else { unseal_strictly(&path, &text)? };
        let mut record: RunRecord = serde_json::from_str(&text).map_err(|error| damaged(&path, &error))?;
        if let Some(name) =
            record.content.keys().chain(record.replaced.keys()).find(|name| !content::is_of_a_run(name))
        {
            return Err(Error::content(
                &path,
                format!("is damaged: it lists {name:?}, which is no file of a run"),
            ));
        }
        let preparation =
            (!record.preparation_digest.is_empty()).then_some(record.preparation_digest.as_str());
        record.source = record.source.in_folder(&self.path, preparation);
        times::read_into(&self.path, &mut record);
        Ok(record)
    }

    /// True if the run has a table of states, which it has once its test has begun.
    pub fn has_series(&self) -> bool {
        self.has(SERIES) || self.has_states_so_far()
    }

    /// The states that a test under way, or one that was killed or failed, has recorded so far; none of a run whose tables have all
    /// of them. The state under way is not among them.
    ///
    /// # Errors
    /// As [`Run::record`]; [`Error::File`] if the file of the states cannot be read.
    pub fn states_so_far(&self) -> Result<Arc<Vec<RecordedState>>> {
        // They are read once, so that the tables that this value gives have the same states.
        let mut known = self.states.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(states) = &*known {
            return Ok(states.clone());
        }
        let states = match self.record()?.status {
            RunStatus::Running | RunStatus::Failed => {
                states::read(&self.path.join(STATES), self.vocabulary.sensors())?
            }
            RunStatus::Interrupted | RunStatus::Finished => Vec::new(),
        };
        Ok(known.insert(Arc::new(states)).clone())
    }

    fn has_states_so_far(&self) -> bool {
        self.states_so_far().is_ok_and(|states| !states.is_empty())
    }

    /// The same run, as it is now: whatever was read before is read and compared again.
    pub fn now(&self) -> Run {
        Run::in_folder(&self.path).with_vocabulary(&self.vocabulary)
    }

    /// The table of states; of a test under way those so far.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::read`]; [`Error::Content`] if it is not the file that the run wrote.
    pub fn series(&self) -> Result<Table> {
        self.table_so_far(SERIES, |record| Some(record.series))
    }

    /// The table of force histograms; of a test under way that of the states so far.
    ///
    /// # Errors
    /// As [`Run::series`].
    pub fn forces(&self) -> Result<Table> {
        self.table_so_far(FORCES, |record| histogram_of(&record, FORCE_HISTOGRAM))
    }

    /// A table with the rows of the states that a test under way has recorded since it was written.
    fn table_so_far(&self, name: &str, of: impl FnOnce(Record) -> Option<Table>) -> Result<Table> {
        // They are read first: a test that ends in between has them all in the table.
        let later = self.states_so_far()?;
        let later = if later.is_empty() { None } else { of(RecordedState::record(&later)) };
        let Some(later) = later else { return self.table(name) };
        let saved = self.path.join(name).is_file().then(|| self.table(name)).transpose()?;
        Ok(states::joined(saved, later))
    }

    /// Names of the histograms beside that of the forces, sorted.
    ///
    /// # Errors
    /// As [`Run::record`].
    pub fn histograms(&self) -> Result<Vec<String>> {
        let record = self.record()?;
        let names = record.content.keys().filter_map(|name| {
            name.strip_prefix(HISTOGRAMS)?.strip_prefix('/')?.strip_suffix(".parquet").map(str::to_string)
        });
        let is_there = |name: &String| self.has(&content::histogram_file(name));
        let mut names: Vec<String> = names.filter(is_there).collect();
        let later = self.states_so_far()?;
        let told = later.iter().flat_map(|state| &state.histograms).map(|histogram| &histogram.name);
        for name in told.filter(|name| *name != FORCE_HISTOGRAM) {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        names.sort();
        Ok(names)
    }

    /// The table of a histogram of that name.
    ///
    /// # Errors
    /// As [`Run::series`]; [`Error::Value`] if the name is no plain word.
    pub fn histogram(&self, name: &str) -> Result<Table> {
        check_name("histogram", name)?;
        self.table_so_far(&content::histogram_file(name), |record| histogram_of(&record, name))
    }

    /// The history of the preparation; `None` if it was not recorded.
    ///
    /// # Errors
    /// As [`Run::series`].
    pub fn preparation(&self) -> Result<Option<Table>> {
        self.has(PREPARATION).then(|| self.table(PREPARATION)).transpose()
    }

    /// Names of the tables of the run: `series`, `forces`, `preparation`, and those of its further histograms.
    ///
    /// # Errors
    /// As [`Run::record`].
    pub fn tables(&self) -> Result<Vec<String>> {
        let under_way = self.has_states_so_far();
        let is_there = |name: &&str| self.has(name) || (under_way && [SERIES, FORCES].contains(name));
        let own = content::TABLES.into_iter().filter(is_there);
        let mut names: Vec<String> = own.map(|name| name.trim_end_matches(".parquet").to_string()).collect();
        names.extend(self.histograms()?);
        Ok(names)
    }

    /// A table by its name, one of [`Run::tables`].
    ///
    /// # Errors
    /// As [`Run::series`]; [`Error::Value`] if the name is no plain word.
    pub fn table_named(&self, name: &str) -> Result<Table> {
        check_name("table", name)?;
        let file = format!("{name}.parquet");
        match file.as_str() {
            SERIES => self.series(),
            FORCES => self.forces(),
            PREPARATION => self.table(PREPARATION),
            _ => self.histogram(name),
        }
    }

    /// Names of the snapshots, sorted: those that the record lists. Records of earlier versions list none; there the names are
    /// those in the folder.
    ///
    /// # Errors
    /// As [`Run::record`].
    pub fn snapshots(&self) -> Result<Vec<String>> {
        let record = self.record()?;
        if !record.lists_all() {
            return Ok(content::usual_snapshots(&self.path));
        }
        let names = record.content.keys().filter_map(|name| {
            name.strip_prefix(SNAPSHOTS)?.strip_prefix('/')?.strip_suffix(".json").map(str::to_string)
        });
        let is_there = |name: &String| content::snapshot_files(name).iter().all(|file| self.has(file));
        Ok(names.filter(is_there).collect())
    }

    /// A snapshot.
    ///
    /// # Errors
    /// As for [`snapshot::read_snapshot`]; [`Error::Content`] if a file is not the one that the run wrote.
    pub fn snapshot(&self, name: &str) -> Result<Assembly> {
        check_name("snapshot", name)?;
        self.check_tables()?;
        for file in content::snapshot_files(name).iter().chain(&content::further_snapshot_files(name)) {
            self.compared(file)?;
        }
        snapshot::read_snapshot(&self.path.join(SNAPSHOTS), name)
    }
}

/// The table of a histogram of a record.
fn histogram_of(record: &Record, name: &str) -> Option<Table> {
    record.histogram_tables().find(|(known, _)| *known == name).map(|(_, table)| table)
}

#[cfg(test)]
mod tests;
