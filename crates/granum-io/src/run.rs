//! The folder of a run: `case.toml` (resolved), `series.parquet`, `forces.parquet`, `snapshots/`, and `run.json`
//! ([`RunRecord`]). Nothing else is needed to measure, train or draw again.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use granum_dem::assembly::Assembly;
use serde::{Deserialize, Deserializer, Serialize};
use sha2::{Digest, Sha256};

use crate::atomic::write_atomically;
use crate::case::Case;
use crate::error::{Error, Result};
use crate::folder::OutputFolder;
use crate::snapshot;
use crate::table::Table;

/// Newest layout of `run.json` that this version reads and writes.
pub const RUN_FORMAT: u32 = 1;

const CASE: &str = "case.toml";
const SERIES: &str = "series.parquet";
const FORCES: &str = "forces.parquet";
const SNAPSHOTS: &str = "snapshots";
const RECORD: &str = "run.json";
/// Everything that a run puts into its folder.
const CONTENTS: [&str; 6] = [CASE, SERIES, FORCES, SNAPSHOTS, RECORD, "checkpoint"];

/// How far a run got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunStatus {
    /// It goes on, or was killed.
    #[default]
    Running,
    /// It was stopped in good order (Ctrl-C) before its end.
    Interrupted,
    /// It reached its end.
    Finished,
    /// It ended with an error.
    Failed,
}

/// One judgement of a run on itself: a measure against its threshold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QualityFlag {
    /// What is judged, e.g. `servo_error_rms`.
    pub name: String,
    /// The measured value (a null in the file is NaN).
    #[serde(deserialize_with = "null_is_nan")]
    pub value: f64,
    /// The largest value that is good.
    pub limit: f64,
    /// True if the value is good.
    pub passed: bool,
    /// What to change if it is not.
    pub advice: String,
}

impl QualityFlag {
    /// Judges a measure that is good up to `limit`; NaN is not good.
    pub fn at_most(name: impl Into<String>, value: f64, limit: f64, advice: impl Into<String>) -> Self {
        QualityFlag { name: name.into(), value, limit, passed: value <= limit, advice: advice.into() }
    }
}

/// The machine that a run ran on. It decides times, never results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Operating system and processor family, e.g. `linux x86_64`.
    pub system: String,
    /// Instruction set in use, e.g. `avx512`.
    pub instruction_set: String,
    /// Threads in use.
    pub threads: usize,
    /// Threads that the machine offers.
    pub available_threads: usize,
}

impl Machine {
    /// This machine, with the instruction set and threads in use.
    pub fn here(instruction_set: impl Into<String>, threads: usize) -> Machine {
        Machine {
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            instruction_set: instruction_set.into(),
            threads,
            available_threads: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}

/// What `run.json` says of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Layout of this file, [`RUN_FORMAT`].
    pub format: u32,
    /// Version of granum that ran.
    pub granum_version: String,
    /// What was run, e.g. `prepare`, `shear`.
    pub kind: String,
    /// How far it got.
    pub status: RunStatus,
    /// Seed of the sample.
    pub seed: u64,
    /// [`Case::digest`] of the case.
    pub case_digest: String,
    /// [`Case::preparation_digest`] of the case.
    pub preparation_digest: String,
    /// Number of grains.
    pub grains: usize,
    /// Steps by phase.
    #[serde(default)]
    pub steps: BTreeMap<String, u64>,
    /// Seconds of wall time by phase.
    #[serde(default)]
    pub wall_seconds: BTreeMap<String, f64>,
    /// What the run measured once, by name, in SI units: solid fraction, coordination numbers...
    #[serde(default, deserialize_with = "nulls_are_nan")]
    pub measures: BTreeMap<String, f64>,
    /// The machine.
    pub machine: Machine,
    /// The run's judgement on itself.
    #[serde(default)]
    pub quality: Vec<QualityFlag>,
    /// SHA-256 of the files with physical content, by name.
    #[serde(default)]
    pub content: BTreeMap<String, String>,
    /// Remarks for people.
    #[serde(default)]
    pub notes: Vec<String>,
}

impl RunRecord {
    /// The start of a record for a case.
    pub fn new(
        kind: impl Into<String>,
        granum_version: impl Into<String>,
        case: &Case,
        machine: Machine,
    ) -> Self {
        RunRecord {
            format: RUN_FORMAT,
            granum_version: granum_version.into(),
            kind: kind.into(),
            seed: case.preparation.seed,
            case_digest: case.digest(),
            preparation_digest: case.preparation_digest(),
            grains: case.grains.count,
            machine,
            ..RunRecord::default()
        }
    }

    /// Product of grains and steps over all phases.
    pub fn grain_steps(&self) -> u64 {
        self.steps.values().sum::<u64>().saturating_mul(self.grains as u64)
    }

    /// True if every judgement is good.
    pub fn is_good(&self) -> bool {
        self.quality.iter().all(|flag| flag.passed)
    }

    /// True if the run is finished, was of this whole case, and by this version: then it need not be run again.
    pub fn answers(&self, case: &Case, granum_version: &str) -> bool {
        self.status == RunStatus::Finished
            && self.case_digest == case.digest()
            && self.granum_version == granum_version
    }
}

fn null_is_nan<'de, D: Deserializer<'de>>(input: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(input)?.unwrap_or(f64::NAN))
}

fn nulls_are_nan<'de, D: Deserializer<'de>>(
    input: D,
) -> std::result::Result<BTreeMap<String, f64>, D::Error> {
    let map = BTreeMap::<String, Option<f64>>::deserialize(input)?;
    Ok(map.into_iter().map(|(name, value)| (name, value.unwrap_or(f64::NAN))).collect())
}

/// The folder of a run, for reading; nothing is locked and nothing changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    path: PathBuf,
}

impl Run {
    /// A run folder.
    ///
    /// # Errors
    /// [`Error::Content`] if there is no such folder, or it holds no run.
    pub fn at(path: impl AsRef<Path>) -> Result<Run> {
        let path = path.as_ref();
        if !path.is_dir() {
            return Err(Error::content(path, "there is no such folder"));
        }
        if !path.join(RECORD).is_file() && !path.join(CASE).is_file() {
            return Err(Error::content(path, format!("holds no run: neither {RECORD} nor {CASE} is there")));
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
    /// As [`Case::read`].
    pub fn case(&self) -> Result<Case> {
        Case::read(self.path.join(CASE))
    }

    /// The record.
    ///
    /// # Errors
    /// If `run.json` is missing, damaged or of a newer version.
    pub fn record(&self) -> Result<RunRecord> {
        let path = self.path.join(RECORD);
        let text = crate::text::read_small(&path, 1 << 24)?;
        check_format(&path, &text, RUN_FORMAT)?;
        serde_json::from_str(&text).map_err(|error| damaged(&path, &error))
    }

    /// The table of states.
    ///
    /// # Errors
    /// As [`crate::parquet::read`].
    pub fn series(&self) -> Result<Table> {
        crate::parquet::read(&self.path.join(SERIES), None)
    }

    /// The table of force histograms.
    ///
    /// # Errors
    /// As [`crate::parquet::read`].
    pub fn forces(&self) -> Result<Table> {
        crate::parquet::read(&self.path.join(FORCES), None)
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
    /// As [`snapshot::read_snapshot`].
    pub fn snapshot(&self, name: &str) -> Result<Assembly> {
        snapshot::read_snapshot(&self.path.join(SNAPSHOTS), name)
    }
}

/// The folder of a run, for writing; it is locked until this is dropped.
#[derive(Debug)]
pub struct RunFolder {
    folder: OutputFolder,
}

impl RunFolder {
    /// Makes the folder of a new run; with `force` an old run in it is removed, and nothing else.
    ///
    /// # Errors
    /// As [`OutputFolder::create`].
    pub fn create(path: impl AsRef<Path>, force: bool) -> Result<RunFolder> {
        let folder = OutputFolder::create(path, force)?;
        folder.clear(&CONTENTS)?;
        Ok(RunFolder { folder })
    }

    /// Opens the folder of a run to go on with it.
    ///
    /// # Errors
    /// As [`OutputFolder::open`].
    pub fn open(path: impl AsRef<Path>) -> Result<RunFolder> {
        Ok(RunFolder { folder: OutputFolder::open(path)? })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The same folder for reading.
    pub fn run(&self) -> Run {
        Run { path: self.folder.path().to_path_buf() }
    }

    /// Writes the resolved case.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_case(&self, case: &Case) -> Result<()> {
        write_atomically(&self.folder.file(CASE), |file| {
            io::Write::write_all(file, case.resolved_toml().as_bytes())
        })
    }

    /// Writes the table of states.
    ///
    /// # Errors
    /// As [`crate::parquet::write`].
    pub fn write_series(&self, table: &Table) -> Result<()> {
        crate::parquet::write(&self.folder.file(SERIES), table)
    }

    /// Writes the table of force histograms.
    ///
    /// # Errors
    /// As [`crate::parquet::write`].
    pub fn write_forces(&self, table: &Table) -> Result<()> {
        crate::parquet::write(&self.folder.file(FORCES), table)
    }

    /// Writes a snapshot, e.g. `sample` or `end`.
    ///
    /// # Errors
    /// As [`snapshot::write_snapshot`]; [`Error::Value`] if the name is no plain word.
    pub fn write_snapshot(&self, name: &str, assembly: &Assembly) -> Result<()> {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        if name.is_empty() || !name.chars().all(plain) {
            let message = "is no name of a snapshot; use letters, digits, - and _".to_string();
            return Err(Error::Value { name: "snapshot".into(), value: name.into(), message });
        }
        snapshot::write_snapshot(&self.folder.subfolder(SNAPSHOTS)?, name, assembly)
    }

    /// Writes the record, with the digests of the series and forces that are there.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_record(&self, record: &RunRecord) -> Result<()> {
        let mut record = record.clone();
        record.format = RUN_FORMAT;
        for name in [SERIES, FORCES] {
            let path = self.folder.file(name);
            if path.is_file() {
                record.content.insert(name.to_string(), file_digest(&path)?);
            }
        }
        write_atomically(&self.folder.file(RECORD), |file| {
            serde_json::to_writer_pretty(&mut *file, &record).map_err(io::Error::from)?;
            io::Write::write_all(file, b"\n")
        })
    }
}

/// SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// [`Error::File`] if it cannot be read.
pub fn file_digest(path: &Path) -> Result<String> {
    let mut file = File::open(path).map_err(Error::file("read", path))?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match io::Read::read(&mut file, &mut buffer).map_err(Error::file("read", path))? {
            0 => return Ok(crate::case::hexadecimal(&hash.finalize())),
            count => hash.update(&buffer[..count]),
        }
    }
}

/// Refuses JSON whose `format` is newer than `newest`.
pub(crate) fn check_format(path: &Path, text: &str, newest: u32) -> Result<()> {
    #[derive(Deserialize)]
    struct Head {
        format: u32,
    }
    let head: Head = serde_json::from_str(text).map_err(|error| damaged(path, &error))?;
    if head.format > newest {
        let message = format!(
            "was written by a newer granum (format {}, known here up to {newest}); use that version",
            head.format
        );
        return Err(Error::content(path, message));
    }
    Ok(())
}

/// JSON that cannot be read: cut short, or wrong somewhere.
pub(crate) fn damaged(path: &Path, error: &serde_json::Error) -> Error {
    let why = if error.is_eof() { "is cut short" } else { "is damaged" };
    Error::content(path, format!("{why} ({error})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Column;
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

    #[test]
    fn a_run_comes_back() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("run");
        let assembly = crate::snapshot::tests::assembly();
        let folder = RunFolder::create(&path, false).unwrap();
        folder.write_case(&Case::default()).unwrap();
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
        fs::write(path.join("notes.txt"), "mine").unwrap();
        drop(folder);
        assert!(matches!(RunFolder::create(&path, false), Err(Error::Exists(_))));
        drop(RunFolder::create(&path, true).unwrap());
        assert!(!path.join("series.parquet").exists() && path.join("notes.txt").exists());
    }

    #[test]
    fn records_that_cannot_be_read_say_why() {
        let base = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(base.path(), false).unwrap();
        assert!(Run::at(base.path()).unwrap_err().to_string().contains("holds no run"));
        assert!(Run::at(base.path().join("x")).unwrap_err().to_string().contains("no such folder"));
        folder.write_record(&record()).unwrap();
        let path = base.path().join("run.json");
        let text = fs::read_to_string(&path).unwrap();
        let message = |text: &str| {
            fs::write(&path, text).unwrap();
            folder.run().record().unwrap_err().to_string()
        };
        assert!(message(&text[..text.len() / 2]).contains("run.json: is cut short (EOF"));
        let newer = text.replace("\"format\": 1", "\"format\": 2");
        assert!(message(&newer).contains("was written by a newer granum (format 2, known here up to 1)"));
        assert!(message(&text.replace("5000", "\"many\"")).contains("run.json: is damaged (invalid type"));
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
