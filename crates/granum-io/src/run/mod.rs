//! The folder of a run: `case.toml` (resolved), `series.parquet`, `forces.parquet`, `snapshots/`, and `run.json`
//! ([`RunRecord`]). It contains everything that is needed to measure, train or plot again.

mod record;
mod times;

use std::io;
use std::path::{Path, PathBuf};

use granum_core::assembly::Assembly;
use granum_core::digest::Digest;

use crate::atomic::{write_atomically, write_keeping_previous};
use crate::case::{Case, Reading};
use crate::error::{Error, Result};
use crate::folder::{OutputFolder, check_name};
use crate::format::{check_format, damaged};
use crate::sealed::{unseal, unseal_strictly, write_sealed};
use crate::shell::ShowPath;
use crate::snapshot;
use granum_core::Table;

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
/// Files that a run or a report writes into the folder of a run. The record is removed first: a folder without one no longer
/// counts as a run.
const CONTENTS: [&str; 10] = [
    RECORD,
    CASE,
    SERIES,
    FORCES,
    PREPARATION,
    CHECKPOINT,
    PREVIOUS_CHECKPOINT,
    REFUSED_CHECKPOINT,
    REPORT,
    times::TIMES,
];
/// Inner folders, and the endings of the names of granum's files in them.
const FOLDERS: [(&str, &[&str]); 3] = [
    (SNAPSHOTS, &[".json", ".grains.parquet", ".contacts.parquet"]),
    (HISTOGRAMS, &[".parquet"]),
    (FIGURES, &[".svg"]),
];

/// Name of the checkpoint in a run folder.
pub const CHECKPOINT: &str = "checkpoint";
/// Name of the previous checkpoint.
pub const PREVIOUS_CHECKPOINT: &str = "checkpoint.previous";
/// Name given to a checkpoint that could not be used, so that it does not replace the previous valid one.
pub const REFUSED_CHECKPOINT: &str = "checkpoint.refused";

/// The folder of a run, for reading; nothing is locked or changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    path: PathBuf,
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
        if !path.join(RECORD).is_file() && !path.join(CASE).is_file() {
            return Err(Error::content(path, format!("contains no run: neither {RECORD} nor {CASE} exists")));
        }
        Ok(Run { path: path.to_path_buf() })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The resolved case.
    ///
    /// # Errors
    /// As for [`Case::read`].
    pub fn case(&self) -> Result<Case> {
        let path = self.path.join(CASE);
        let pending = || self.record().ok().and_then(|record| record.unwritten_case);
        match pending().filter(|_| !path.is_file()) {
            Some(text) => Case::parse_as(&text, &path.shown(), Reading::recorded()),
            None => Case::read_as(path, Reading::recorded()),
        }
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
        let mut record = serde_json::from_str(&text).map_err(|error| damaged(&path, &error))?;
        times::read_into(&self.path, &mut record);
        Ok(record)
    }

    /// Path of the table of states, which exists once a test has begun.
    pub fn series_path(&self) -> PathBuf {
        self.path.join(SERIES)
    }

    /// The table of states.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::read`].
    pub fn series(&self) -> Result<Table> {
        crate::formats::parquet::read(&self.path.join(SERIES), None)
    }

    /// The table of force histograms.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::read`].
    pub fn forces(&self) -> Result<Table> {
        crate::formats::parquet::read(&self.path.join(FORCES), None)
    }

    /// Names of the histograms beside that of the forces, sorted.
    ///
    /// # Errors
    /// [`Error::File`] if the folder of histograms cannot be read.
    pub fn histograms(&self) -> Result<Vec<String>> {
        let folder = self.path.join(HISTOGRAMS);
        if !folder.is_dir() {
            return Ok(Vec::new());
        }
        let mut names = Vec::new();
        for entry in std::fs::read_dir(&folder).map_err(Error::file("read", &folder))? {
            let name = entry.map_err(Error::file("read", &folder))?.file_name();
            names.extend(name.to_str().and_then(|name| name.strip_suffix(".parquet")).map(str::to_string));
        }
        names.sort();
        Ok(names)
    }

    /// The table of a histogram of that name.
    ///
    /// # Errors
    /// As [`crate::formats::parquet::read`]; [`Error::Value`] if the name is no plain word.
    pub fn histogram(&self, name: &str) -> Result<Table> {
        check_name("histogram", name)?;
        crate::formats::parquet::read(&self.path.join(HISTOGRAMS).join(format!("{name}.parquet")), None)
    }

    /// The history of the preparation; `None` if it was not recorded.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::read`].
    pub fn preparation(&self) -> Result<Option<Table>> {
        let path = self.path.join(PREPARATION);
        path.is_file().then(|| crate::formats::parquet::read(&path, None)).transpose()
    }

    /// Names of the snapshots, sorted.
    ///
    /// # Errors
    /// [`Error::File`] if the folder of snapshots cannot be read.
    pub fn snapshots(&self) -> Result<Vec<String>> {
        snapshot::list_snapshots(&self.path.join(SNAPSHOTS))
    }

    /// A snapshot.
    ///
    /// # Errors
    /// As for [`snapshot::read_snapshot`].
    pub fn snapshot(&self, name: &str) -> Result<Assembly> {
        snapshot::read_snapshot(&self.path.join(SNAPSHOTS), name)
    }
}

/// The folder of a run, for writing; it is locked until this value is dropped.
#[derive(Debug)]
pub struct RunFolder {
    folder: OutputFolder,
}

impl RunFolder {
    /// Creates the folder of a new run; with `force`, a previous run in it is removed, and nothing else.
    ///
    /// # Errors
    /// As for [`OutputFolder::create`].
    pub fn create(path: impl AsRef<Path>, force: bool) -> Result<RunFolder> {
        let folder = OutputFolder::create(path, force)?;
        folder.refuse_links(&FOLDERS.map(|(name, _)| name))?;
        folder.clear(&CONTENTS)?;
        for (name, ends) in FOLDERS {
            folder.clear_inside(name, ends)?;
        }
        Ok(RunFolder { folder })
    }

    /// Opens the folder of a run to continue it.
    ///
    /// # Errors
    /// As for [`OutputFolder::open`].
    pub fn open(path: impl AsRef<Path>) -> Result<RunFolder> {
        let folder = OutputFolder::open(path)?;
        folder.refuse_links(&FOLDERS.map(|(name, _)| name))?;
        for (name, _) in FOLDERS {
            folder.remove_unfinished_inside(name)?;
        }
        Ok(RunFolder { folder })
    }

    /// Writes a checkpoint through `fill`; the previous one is kept as [`PREVIOUS_CHECKPOINT`].
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written; both existing checkpoints are then unchanged.
    pub fn write_checkpoint(&self, fill: impl FnOnce(&mut dyn io::Write) -> io::Result<()>) -> Result<()> {
        let previous = self.folder.file(PREVIOUS_CHECKPOINT);
        write_keeping_previous(&self.folder.file(CHECKPOINT), &previous, |file| fill(file))
    }

    /// Renames a checkpoint that cannot be used to [`REFUSED_CHECKPOINT`].
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be renamed.
    pub fn put_checkpoint_aside(&self) -> Result<()> {
        let path = self.folder.file(CHECKPOINT);
        if !path.exists() {
            return Ok(());
        }
        std::fs::rename(&path, self.folder.file(REFUSED_CHECKPOINT)).map_err(Error::file("rename", &path))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The same folder for reading.
    pub fn run(&self) -> Run {
        Run { path: self.folder.path().to_path_buf() }
    }

    /// Writes the resolved case, with the name of the packing that replaces the random insertion, if there is one.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_case(&self, case: &Case, packing: Option<&str>) -> Result<()> {
        let text = case.resolved_toml_with(packing);
        write_atomically(&self.folder.file(CASE), |file| io::Write::write_all(file, text.as_bytes()))
    }

    /// Writes the history of the preparation.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::write`].
    pub fn write_preparation(&self, table: &Table) -> Result<()> {
        crate::formats::parquet::write(&self.folder.file(PREPARATION), table)
    }

    /// Writes the table of states.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::write`].
    pub fn write_series(&self, table: &Table) -> Result<()> {
        crate::formats::parquet::write(&self.folder.file(SERIES), table)
    }

    /// Writes the table of force histograms.
    ///
    /// # Errors
    /// As for [`crate::formats::parquet::write`].
    pub fn write_forces(&self, table: &Table) -> Result<()> {
        crate::formats::parquet::write(&self.folder.file(FORCES), table)
    }

    /// Writes the table of another histogram than that of the forces.
    ///
    /// # Errors
    /// As [`crate::formats::parquet::write`]; [`Error::Value`] if the name is no plain word.
    pub fn write_histogram(&self, name: &str, table: &Table) -> Result<()> {
        check_name("histogram", name)?;
        let path = self.folder.subfolder(HISTOGRAMS)?.join(format!("{name}.parquet"));
        crate::formats::parquet::write(&path, table)
    }

    /// Writes a snapshot, e.g. `sample` or `end`.
    ///
    /// # Errors
    /// As for [`snapshot::write_snapshot`]; [`Error::Value`] if the name is not a plain word.
    pub fn write_snapshot(&self, name: &str, assembly: &Assembly) -> Result<()> {
        check_name("snapshot", name)?;
        snapshot::write_snapshot(&self.folder.subfolder(SNAPSHOTS)?, name, assembly)
    }

    /// Writes the record, with the digests of the existing tables.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_record(&self, record: &RunRecord) -> Result<()> {
        let mut record = record.clone();
        record.format = RUN_FORMAT;
        let histograms = self.run().histograms()?;
        let histograms = histograms.iter().map(|name| format!("{HISTOGRAMS}/{name}.parquet"));
        for name in [SERIES, FORCES, PREPARATION].map(String::from).into_iter().chain(histograms) {
            let path = self.folder.path().join(&name);
            if path.is_file() {
                record.content.insert(name, file_digest(&path)?);
            }
        }
        // The record comes first: a folder in which the disk was full or the process was killed before it is an empty one.
        write_sealed(&self.folder.file(RECORD), &record)?;
        times::write(self.folder.path(), &record)
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

    #[test]
    fn force_removes_the_old_run_and_nothing_else() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        let folder = RunFolder::create(&path, false).unwrap();
        folder.write_series(&table()).unwrap();
        folder.write_checkpoint(|out| out.write_all(b"one")).unwrap();
        folder.write_checkpoint(|out| out.write_all(b"two")).unwrap();
        folder.write_snapshot("end", &crate::snapshot::tests::assembly()).unwrap();
        drop(folder);
        fs::create_dir(path.join("figures")).unwrap();
        for name in ["report.html", "figures/stress.svg", "snapshots/.end.json.1-0.granum-unfinished"] {
            fs::write(path.join(name), "old").unwrap();
        }
        for name in ["notes.txt", "figures/mine.png"] {
            fs::write(path.join(name), "mine").unwrap();
        }
        assert!(matches!(RunFolder::create(&path, false), Err(Error::Exists(_))));
        drop(RunFolder::create(&path, true).unwrap());
        let mut left: Vec<_> = fs::read_dir(&path).unwrap().map(|e| e.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, [".granum-lock", "figures", "notes.txt"]);
        assert_eq!(fs::read_dir(path.join("figures")).unwrap().count(), 1);
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
