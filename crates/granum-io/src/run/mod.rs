//! The folder of a run: `case.toml` (resolved), `series.parquet`, `forces.parquet`, `snapshots/`, and `run.json`
//! ([`RunRecord`]). It contains everything that is needed to measure, train or plot again.

mod check;
mod content;
mod record;
mod run_folder;
mod times;

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use granum_core::assembly::Assembly;
use granum_core::digest::Digest;
use granum_core::parallel;

use crate::aside;
use crate::case::{Case, Reading};
use crate::error::{Error, Result};
use crate::folder::{OutputFolder, check_name};
use crate::format::{check_format, damaged};
use crate::sealed::{unseal, unseal_strictly};
use crate::shell::ShowPath;
use crate::snapshot;
use granum_core::Table;

pub use check::Fault;
pub use run_folder::RunFolder;

pub use record::{
    Machine, OWN_ENGINE, PackingRecord, QualityFlag, RUN_FORMAT, RunRecord, RunSource, RunStatus,
    nulls_are_nan,
};

pub(crate) const CASE: &str = "case.toml";
const SERIES: &str = "series.parquet";
const FORCES: &str = "forces.parquet";
const PREPARATION: &str = "preparation.parquet";
const SNAPSHOTS: &str = "snapshots";
const HISTOGRAMS: &str = "histograms";
pub(crate) const RECORD: &str = "run.json";
const REPORT: &str = "report.html";
const FIGURES: &str = "figures";
/// Inner folders, in whose places links are refused.
const FOLDERS: [&str; 3] = [SNAPSHOTS, HISTOGRAMS, FIGURES];

/// Name of the checkpoint in a run folder.
pub const CHECKPOINT: &str = "checkpoint";
/// Name of the previous checkpoint.
pub const PREVIOUS_CHECKPOINT: &str = "checkpoint.previous";
/// Name given to a checkpoint that could not be used, so that it does not replace the previous valid one.
pub const REFUSED_CHECKPOINT: &str = "checkpoint.refused";

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
        Ok(Run::of(path))
    }

    /// The run whose folder of snapshots this is, if it is one.
    pub(crate) fn of_snapshots(run: &Path, snapshots: &Path) -> Option<Run> {
        let run = if run.as_os_str().is_empty() { Path::new(".") } else { run };
        let is_its =
            snapshots.file_name().is_some_and(|name| name == SNAPSHOTS) && run.join(RECORD).is_file();
        is_its.then(|| Run::of(run))
    }

    fn of(path: &Path) -> Run {
        Run { path: path.to_path_buf(), compared: Arc::default() }
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
        let case = match pending.filter(|_| !path.is_file()) {
            Some(text) => Case::parse_as(text, &path.shown(), Reading::recorded())?,
            None => Case::read_as(&path, Reading::recorded())?,
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
    pub fn faults(&self) -> Result<Vec<Fault>> {
        self.case()?;
        let record = self.record()?;
        let mut names: Vec<&str> = record.content.keys().map(String::as_str).collect();
        names.extend(content::TABLES.into_iter().filter(|name| !record.content.contains_key(*name)));
        let faults = parallel::map(names.len(), 0, |k| check::fault(&self.path, &record, names[k]))?;
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

    /// The path of a file after it was compared with the record.
    fn compared(&self, name: &str) -> Result<PathBuf> {
        let path = self.path.join(name);
        let mut compared = self.compared.lock().unwrap_or_else(PoisonError::into_inner);
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

    /// The record.
    ///
    /// # Errors
    /// If `run.json` is missing, damaged or of a newer version.
    pub fn record(&self) -> Result<RunRecord> {
        let path = self.path.join(RECORD);
        if !path.is_file() {
            let message = format!(
                "holds a case but no {RECORD}: the run was ended before it started, or the file was removed; repeat \
                 the command that made it, with --force"
            );
            return Err(Error::content(&self.path, message));
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
        times::read_into(&self.path, &mut record);
        Ok(record)
    }

    /// True if the run has a table of states, which it has once its test has begun.
    pub fn has_series(&self) -> bool {
        self.has(SERIES)
    }

    /// The table of states.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::read`]; [`Error::Content`] if it is not the file that the run wrote.
    pub fn series(&self) -> Result<Table> {
        self.table(SERIES)
    }

    /// The table of force histograms.
    ///
    /// # Errors
    /// As [`Run::series`].
    pub fn forces(&self) -> Result<Table> {
        self.table(FORCES)
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
        Ok(names.filter(is_there).collect())
    }

    /// The table of a histogram of that name.
    ///
    /// # Errors
    /// As [`Run::series`]; [`Error::Value`] if the name is no plain word.
    pub fn histogram(&self, name: &str) -> Result<Table> {
        check_name("histogram", name)?;
        self.table(&content::histogram_file(name))
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
        let own = content::TABLES.into_iter().filter(|name| self.has(name));
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
        if content::TABLES.contains(&file.as_str()) { self.table(&file) } else { self.histogram(name) }
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
        for file in content::snapshot_files(name) {
            self.compared(&file)?;
        }
        snapshot::read_snapshot(&self.path.join(SNAPSHOTS), name)
    }
}

/// SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// [`Error::File`] if it cannot be read.
pub fn file_digest(path: &Path) -> Result<String> {
    let mut file = granum_core::input::open(path).map_err(Error::file("read", path))?;
    let mut hash = Digest::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match io::Read::read(&mut file, &mut buffer).map_err(Error::file("read", path))? {
            0 => return Ok(hash.finish()),
            count => hash.bytes(&buffer[..count]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::Column;
    use std::collections::BTreeMap;
    use std::fs;

    fn record() -> RunRecord {
        let mut record = RunRecord::new("shear", "0.1.0", &Case::default(), Machine::here("avx2", 2));
        record.status = RunStatus::Finished;
        record.steps.insert("shear".into(), 1000);
        record.wall_seconds.insert("shear".into(), 0.1 + 0.2);
        record.measures.insert("solid_fraction".into(), 0.61);
        record.quality.push(QualityFlag::at_most("servo_error_rms", 0.004, 0.01, "lower the strain rate"));
        record
    }

    fn table() -> Table {
        Table::new(vec![Column::new("deviator_strain", "", vec![0.0, 0.3])]).unwrap()
    }

    /// A folder that holds only times would be neither empty nor a run.
    #[test]
    fn a_record_that_cannot_be_written_leaves_no_times() {
        let base = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(base.path().join("run"), false).unwrap();
        folder.write_case(&Case::default(), None).unwrap();
        fs::create_dir(folder.path().join(RECORD)).unwrap();
        assert!(folder.write_record(&record()).is_err());
        assert!(!folder.path().join(times::TIMES).exists());
        fs::remove_dir(folder.path().join(RECORD)).unwrap();
        folder.write_record(&record()).unwrap();
        assert_eq!(folder.run().record().unwrap().wall_seconds, record().wall_seconds);
    }

    #[test]
    fn a_run_comes_back() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        let assembly = crate::snapshot::tests::assembly();
        let folder = RunFolder::create(&path, false).unwrap();
        folder.write_case(&Case::default(), None).unwrap();
        folder.write_series(&table()).unwrap();
        folder.write_forces(&table()).unwrap();
        folder.write_snapshot("end", &assembly).unwrap();
        folder.write_record(&record()).unwrap();
        drop(folder);
        let run = Run::at(&path).unwrap();
        assert_eq!(run.case().unwrap(), Case::default());
        assert_eq!(run.series().unwrap(), table());
        assert_eq!(run.snapshots().unwrap(), ["end"]);
        assert_eq!(run.snapshot("end").unwrap(), assembly);
        let back = run.record().unwrap();
        assert_eq!(back.content["series.parquet"], back.content["forces.parquet"]);
        assert_eq!(RunRecord { content: BTreeMap::new(), ..back.clone() }, record());
        assert_eq!(back.grain_steps(), 5_000_000);
        assert!(back.answers(&Case::default(), "0.1.0") && !back.answers(&Case::default(), "0.2.0"));
    }

    /// A finished run with a snapshot, a further histogram and a preparation.
    fn whole_run(path: &Path) -> RunFolder {
        let folder = RunFolder::create(path, false).unwrap();
        folder.write_record(&record()).unwrap();
        folder.write_case(&Case::default(), None).unwrap();
        folder.write_checkpoint(|out| out.write_all(b"one")).unwrap();
        folder.write_checkpoint(|out| out.write_all(b"two")).unwrap();
        folder.write_series(&table()).unwrap();
        folder.write_forces(&table()).unwrap();
        folder.write_preparation(&table()).unwrap();
        folder.write_histogram("overlap", &table()).unwrap();
        folder.write_snapshot("end", &crate::snapshot::tests::assembly()).unwrap();
        folder.write_record(&record()).unwrap();
        folder
    }

    fn listing(path: &Path) -> Vec<String> {
        let mut left: Vec<String> = fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        left
    }

    #[test]
    fn force_replaces_the_old_run_and_nothing_else() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        drop(whole_run(&path));
        fs::create_dir(path.join("figures")).unwrap();
        for name in ["report.html", "figures/figure-s1-stress.svg"] {
            fs::write(path.join(name), "old").unwrap();
        }
        let mine = [
            "notes.txt",
            "figures/mine.svg",
            "figures/mine.png",
            "snapshots/my.json",
            "histograms/mine.parquet",
        ];
        for name in mine {
            fs::write(path.join(name), "mine").unwrap();
        }
        assert!(matches!(RunFolder::create(&path, false), Err(Error::Exists(_))));
        let before = listing(&path);
        // Nothing is replaced until the new run writes its first file.
        drop(RunFolder::create(&path, true).unwrap());
        assert_eq!(listing(&path), before);
        assert!(Run::at(&path).unwrap().faults().unwrap().is_empty());
        let folder = RunFolder::create(&path, true).unwrap();
        folder.write_record(&RunRecord { status: RunStatus::Running, ..record() }).unwrap();
        assert_eq!(
            listing(&path),
            [".granum-lock", "figures", "histograms", "notes.txt", "run.json", "seconds.json", "snapshots"]
        );
        for name in mine {
            assert_eq!(fs::read(path.join(name)).unwrap(), b"mine");
        }
        assert_eq!(folder.run().record().unwrap().status, RunStatus::Running);
        assert!(folder.run().snapshots().unwrap().is_empty() && folder.run().tables().unwrap().is_empty());
    }

    #[test]
    fn a_replacement_that_fails_or_is_cut_short_leaves_the_old_run_whole() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        drop(whole_run(&path));
        let whole = || {
            let run = Run::at(&path).unwrap();
            assert!(run.faults().unwrap().is_empty() && run.record().unwrap().status == RunStatus::Finished);
            assert_eq!(run.series().unwrap(), table());
            assert_eq!(run.snapshot("end").unwrap(), crate::snapshot::tests::assembly());
        };
        // The first file cannot be written.
        let folder = RunFolder::create(&path, true).unwrap();
        assert!(folder.write_checkpoint(|_| Err(io::Error::other("the disk is full"))).is_err());
        whole();
        drop(folder);
        // The process was killed after the files were moved, before or after the first new file.
        for new in [None, Some("run.json")] {
            let names = content::written(&path, Run::at(&path).unwrap().record().ok().as_ref());
            aside::set_aside(&path, &names).unwrap();
            if let Some(name) = new {
                fs::write(path.join(name), "{}").unwrap();
            } else {
                let message = Run::at(&path).unwrap_err().to_string();
                assert!(message.contains("was cut short") && message.contains("granum resume"), "{message}");
            }
            drop(RunFolder::open(&path).unwrap());
            whole();
        }
    }

    #[test]
    fn every_changed_bit_and_every_missing_file_is_noticed() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        drop(whole_run(&path));
        let names = [
            "run.json",
            "series.parquet",
            "forces.parquet",
            "preparation.parquet",
            "histograms/overlap.parquet",
            "snapshots/end.json",
            "snapshots/end.grains.parquet",
            "snapshots/end.contacts.parquet",
        ];
        let read_all = || -> Result<()> {
            let run = Run::at(&path)?;
            drop([run.series()?, run.forces()?, run.histogram("overlap")?]);
            drop((run.preparation()?, run.snapshot("end")?));
            Ok(())
        };
        read_all().unwrap();
        let mut noise = 20_061_121_u64;
        for (round, name) in names.iter().cycle().take(400).enumerate() {
            let file = path.join(name);
            let good = fs::read(&file).unwrap();
            noise = noise * 48271 % 2_147_483_647;
            let at = noise as usize % good.len();
            let mut bytes = good.clone();
            bytes[at] ^= 1 << (round / 8 % 8);
            fs::write(&file, &bytes).unwrap();
            let message = read_all().unwrap_err().to_string();
            assert!(message.contains(name), "byte {at} of {name}: {message}");
            let told = Run::at(&path).unwrap().faults();
            let told = told.map(|faults| faults.iter().map(ToString::to_string).collect::<String>());
            assert!(told.unwrap_or_else(|error| error.to_string()).contains(name), "{name}");
            fs::write(&file, good).unwrap();
        }
        for name in names.iter().skip(1) {
            let (file, other) = (path.join(name), base.path().join("kept"));
            fs::rename(&file, &other).unwrap();
            let message = read_all().unwrap_err().to_string();
            assert!(message.contains(name) && message.contains("is missing"), "{message}");
            fs::rename(&other, &file).unwrap();
        }
        // A file that the record does not list is not a part of the run, whatever it holds.
        let folder = RunFolder::open(&path).unwrap();
        assert!(folder.check_present().is_ok());
        fs::remove_file(path.join("snapshots/end.json")).unwrap();
        assert!(
            folder.check_present().unwrap_err().to_string().contains("end.json: was removed while the run")
        );
        drop(folder);
        let bare = RunFolder::create(base.path().join("bare"), false).unwrap();
        bare.write_case(&Case::default(), None).unwrap();
        bare.write_record(&record()).unwrap();
        fs::copy(path.join("series.parquet"), bare.path().join("series.parquet")).unwrap();
        let message = bare.run().series().unwrap_err().to_string();
        assert!(message.contains("series.parquet: is not a file of this run"), "{message}");
        assert_eq!(bare.run().faults().unwrap().len(), 1);
    }

    #[test]
    fn a_run_killed_between_its_record_and_a_file_is_whole() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        let folder = whole_run(&path);
        let longer = Table::new(vec![Column::new("deviator_strain", "", vec![0.0, 0.3, 0.4])]).unwrap();
        let old = fs::read(path.join("series.parquet")).unwrap();
        folder.write_series(&longer).unwrap();
        drop(folder);
        // Killed before the new table took its place, and before the new histogram came.
        fs::write(path.join("series.parquet"), &old).unwrap();
        assert!(Run::at(&path).unwrap().faults().unwrap().is_empty());
        assert_eq!(Run::at(&path).unwrap().series().unwrap(), table());
        let folder = RunFolder::open(&path).unwrap();
        folder.write_histogram("second", &table()).unwrap();
        fs::remove_file(path.join("histograms/second.parquet")).unwrap();
        drop(folder);
        let run = Run::at(&path).unwrap();
        assert!(run.faults().unwrap().is_empty());
        assert_eq!(run.histograms().unwrap(), ["overlap"]);
        // The next record is that of the files that are there.
        let folder = RunFolder::open(&path).unwrap();
        folder.write_record(&record()).unwrap();
        let after = folder.run().record().unwrap();
        assert!(after.replaced.is_empty() && !after.content.contains_key("histograms/second.parquet"));
        assert!(folder.run().faults().unwrap().is_empty());
        assert_eq!(folder.run().series().unwrap(), table());
    }

    #[test]
    fn runs_of_earlier_versions_are_read_and_say_what_cannot_be_checked() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        drop(whole_run(&path));
        let mut old: serde_json::Value =
            serde_json::from_slice(&fs::read(path.join(RECORD)).unwrap()).unwrap();
        old["format"] = 1.into();
        old["machine"] = serde_json::to_value(Machine::here("avx2", 2)).unwrap();
        old["wall_seconds"] = serde_json::json!({ "shear": 2.5 });
        old.as_object_mut().unwrap().remove("sha256");
        let content = old["content"].as_object_mut().unwrap();
        content.retain(|name, _| !name.starts_with("snapshots"));
        fs::write(path.join(RECORD), serde_json::to_vec(&old).unwrap()).unwrap();
        fs::remove_file(path.join(times::TIMES)).unwrap();
        fs::write(path.join("snapshots/my.json"), "{}").unwrap();
        let run = Run::at(&path).unwrap();
        assert_eq!(run.record().unwrap().wall_seconds["shear"], 2.5);
        assert_eq!(run.snapshots().unwrap(), ["end"]);
        run.snapshot("end").unwrap();
        assert_eq!(run.uncheckable().unwrap(), content::snapshot_files("end"));
        // Its tables are checked, and a run that goes on gets the SHA-256 of all of its files.
        fs::copy(path.join("snapshots/end.grains.parquet"), path.join("series.parquet")).unwrap();
        assert!(
            Run::at(&path).unwrap().series().unwrap_err().to_string().contains("was changed or exchanged")
        );
        let folder = RunFolder::open(&path).unwrap();
        folder.write_series(&table()).unwrap();
        folder.write_record(&record()).unwrap();
        assert!(folder.run().uncheckable().unwrap().is_empty() && folder.run().faults().unwrap().is_empty());
        assert_eq!(folder.run().record().unwrap().content.len(), 7);
    }

    #[test]
    fn a_run_without_its_case_file_has_the_case_of_its_record() {
        let base = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(base.path(), false).unwrap();
        let mut record = record();
        record.unwritten_case = Some(Case::default().resolved_toml());
        folder.write_record(&record).unwrap();
        assert_eq!(folder.run().case().unwrap(), Case::default());
        folder.write_case(&Case::default(), None).unwrap();
        fs::remove_file(base.path().join("run.json")).unwrap();
        let message = folder.run().record().unwrap_err().to_string();
        assert!(message.contains("holds a case but no run.json"), "{message}");
    }

    #[test]
    fn records_that_cannot_be_read_say_why() {
        let base = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(base.path(), false).unwrap();
        assert!(Run::at(base.path()).unwrap_err().to_string().contains("contains no run"));
        assert!(Run::at(base.path().join("x")).unwrap_err().to_string().contains("no such folder"));
        folder.write_record(&record()).unwrap();
        let path = base.path().join("run.json");
        let text = fs::read_to_string(&path).unwrap();
        let message = |text: &str| {
            fs::write(&path, text).unwrap();
            folder.run().record().unwrap_err().to_string()
        };
        assert!(message(&text[..text.len() / 2]).contains("run.json: is truncated (EOF"));
        let newer = text.replace("\"format\": 2", "\"format\": 3");
        assert!(message(&newer).contains("was written by a newer granum (format 3; this one reads up to 2)"));
        assert!(message(&text.replace("5000", "6000")).contains("run.json: was changed or damaged"));
        let earlier = text.replace("\"format\": 2", "\"format\": 1").replace("5000", "\"many\"");
        let earlier = earlier.split(",\n  \"sha256\"").next().unwrap().to_string() + "\n}";
        assert!(message(&earlier).contains("run.json: is damaged (invalid type"), "{}", message(&earlier));
        assert!(folder.write_snapshot("../end", &Assembly::default()).is_err());
    }

    #[test]
    fn a_measure_that_is_no_number_survives_and_is_not_good() {
        let base = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(base.path(), false).unwrap();
        let mut record = record();
        assert!(record.is_good());
        record.quality.push(QualityFlag::at_most("energy_closure", f64::NAN, 1e-3, ""));
        record.measures.insert("coordination_number".into(), f64::NAN);
        folder.write_record(&record).unwrap();
        let back = folder.run().record().unwrap();
        assert!(back.measures["coordination_number"].is_nan() && back.quality[1].value.is_nan());
        assert!(!back.is_good());
    }

    #[test]
    fn the_digest_of_a_file_is_its_sha_256() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("abc");
        fs::write(&path, "abc").unwrap();
        // FIPS 180-2, appendix B.1.
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(file_digest(&path).unwrap(), known);
    }
}
