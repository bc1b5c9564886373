//! The content of `run.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize};

use super::source::RunSource;
use super::stage_end::StageEndRecord;
use crate::case::Case;

/// Newest layout of `run.json` that this version reads and writes. Since format 2 times are in `seconds.json` and the file ends
/// with its SHA-256.
pub const RUN_FORMAT: u32 = 2;

/// The status of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunStatus {
    /// It is running, or was killed.
    #[default]
    Running,
    /// It was stopped cleanly (Ctrl-C) before its end.
    Interrupted,
    /// It reached its end.
    Finished,
    /// It ended with an error.
    Failed,
}

/// What a run does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RunKind {
    /// It prepares a sample; `prepare` in files.
    #[serde(rename = "prepare")]
    Sample,
    /// It tests a sample; `test` in files, and `shear` in those of earlier versions.
    #[default]
    #[serde(rename = "test", alias = "shear")]
    Test,
}

/// One quality check of a run: a measure compared with its threshold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QualityFlag {
    /// The measure, e.g. `servo_error_rms`.
    pub name: String,
    /// The measured value (a null in the file is NaN).
    #[serde(deserialize_with = "null_is_nan")]
    pub value: f64,
    /// The largest acceptable value.
    pub limit: f64,
    /// True if the value is acceptable.
    pub passed: bool,
    /// What to change if it is not.
    pub advice: String,
}

impl QualityFlag {
    /// A check that passes up to `limit`; NaN does not pass.
    pub fn at_most(name: impl Into<String>, value: f64, limit: f64, advice: impl Into<String>) -> Self {
        QualityFlag { name: name.into(), value, limit, passed: value <= limit, advice: advice.into() }
    }
}

/// The packing that the sample of a run was made from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PackingRecord {
    /// Name of its file.
    pub file_name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// Number of its grains.
    pub grains: usize,
    /// Their mean diameter, m.
    pub mean_diameter: f64,
    /// Half the range of their diameters over the mean; 0 for equal grains.
    pub spread: f64,
}

/// The computer on which a run was executed. It affects times, never results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Operating system and processor family, e.g. `linux x86_64`.
    pub system: String,
    /// Instruction set in use, e.g. `avx512`.
    pub instruction_set: String,
    /// Number of threads in use.
    pub threads: usize,
    /// Number of threads that the machine offers.
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

/// Name of granum's own engine, which records leave out.
pub const OWN_ENGINE: &str = "granum";

/// The word for a test: the kind of its run, and the phase of its steps and times.
pub const TEST: &str = "test";
/// The word for it in records of earlier versions.
const FIRST_WORD_FOR_TEST: &str = "shear";

/// The present word for a phase.
fn of_this_version(word: String) -> String {
    if word == FIRST_WORD_FOR_TEST { TEST.to_string() } else { word }
}

/// Reads values by phase.
pub(super) fn phases_of_any_version<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    input: D,
) -> std::result::Result<BTreeMap<String, T>, D::Error> {
    let phases = BTreeMap::<String, T>::deserialize(input)?;
    Ok(phases.into_iter().map(|(phase, value)| (of_this_version(phase), value)).collect())
}

fn own_engine() -> String {
    OWN_ENGINE.to_string()
}

fn is_own_engine(engine: &str) -> bool {
    engine == OWN_ENGINE || engine.is_empty()
}

/// The content of `run.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Layout of this file, [`RUN_FORMAT`].
    pub format: u32,
    /// Version of granum that executed the run.
    pub granum_version: String,
    /// What the run does.
    pub kind: RunKind,
    /// Its status.
    pub status: RunStatus,
    /// Name of the engine that ran it.
    #[serde(default = "own_engine", skip_serializing_if = "is_own_engine")]
    pub engine: String,
    /// Version of that engine; empty for granum's own, whose version is that of granum.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub engine_version: String,
    /// Seed of the sample; `None` if it was made from a packing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// [`Case::digest_with`] of the case and the packing.
    pub case_digest: String,
    /// [`Case::preparation_digest_with`] of the case and the packing.
    pub preparation_digest: String,
    /// The packing that the sample was made from, if any, also where the run took over such a sample from another run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub packing: Option<PackingRecord>,
    /// The origin of the sample.
    #[serde(default)]
    pub source: RunSource,
    /// The resolved case until `case.toml` is written: a run that is killed in between can be started again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unwritten_case: Option<String>,
    /// The present phase of a run that did not reach its end, e.g. `compaction, trial 2`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub phase: String,
    /// Number of grains.
    pub grains: usize,
    /// Steps by phase: `prepare`, `consolidation`, [`TEST`].
    #[serde(default, deserialize_with = "phases_of_any_version")]
    pub steps: BTreeMap<String, u64>,
    /// Seconds of wall time by phase; in the file `seconds.json`.
    #[serde(default, skip_serializing, deserialize_with = "phases_of_any_version")]
    pub wall_seconds: BTreeMap<String, f64>,
    /// Quantities that the run measured once, by name, in SI units: solid fraction, coordination numbers...
    #[serde(default, deserialize_with = "nulls_are_nan")]
    pub measures: BTreeMap<String, f64>,
    /// The ends of the stages of its test so far, with the states there; empty in records of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stage_ends: Vec<StageEndRecord>,
    /// The machine; in the file `seconds.json`.
    #[serde(default, skip_serializing)]
    pub machine: Machine,
    /// The quality checks of the run.
    #[serde(default)]
    pub quality: Vec<QualityFlag>,
    /// SHA-256 of the files with physical content, by name. [`super::RunFolder`] fills it in.
    #[serde(default)]
    pub content: BTreeMap<String, String>,
    /// SHA-256 of those files that are being replaced, before they are; empty for one that did not exist. If the run is killed at
    /// that moment, either file is one that it wrote.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub replaced: BTreeMap<String, String>,
    /// Remarks for the user.
    #[serde(default)]
    pub notes: Vec<String>,
}

impl RunRecord {
    /// The initial record for a case.
    pub fn new(kind: RunKind, granum_version: impl Into<String>, case: &Case, machine: Machine) -> Self {
        RunRecord {
            format: RUN_FORMAT,
            granum_version: granum_version.into(),
            kind,
            engine: own_engine(),
            seed: Some(case.preparation.seed),
            case_digest: case.digest(),
            preparation_digest: case.preparation_digest(),
            grains: case.grains.count,
            machine,
            ..RunRecord::default()
        }
    }

    /// Records that the sample is made from a packing: its grains, no seed, and digests that include it.
    pub fn set_packing(&mut self, case: &Case, packing: PackingRecord) {
        self.seed = None;
        self.grains = packing.grains;
        self.case_digest = case.digest_with(Some(&packing.sha256));
        self.preparation_digest = case.preparation_digest_with(Some(&packing.sha256));
        self.packing = Some(packing);
    }

    /// SHA-256 of the packing that the sample was made from.
    pub fn packing_digest(&self) -> Option<&str> {
        self.packing.as_ref().map(|packing| packing.sha256.as_str())
    }

    /// True if the run belongs to exactly this case, with the packing that it names.
    pub fn is_of(&self, case: &Case) -> bool {
        self.case_digest == case.digest_with(self.packing_digest())
    }

    /// Product of grains and steps over all phases.
    pub fn grain_steps(&self) -> u64 {
        let steps = self.steps.values().fold(0u64, |sum, steps| sum.saturating_add(*steps));
        steps.saturating_mul(self.grains as u64)
    }

    /// True if [`RunRecord::content`] has every file of the run; records of earlier versions have only its tables.
    pub fn lists_all(&self) -> bool {
        self.format >= 2
    }

    /// True if all quality checks passed.
    pub fn is_good(&self) -> bool {
        self.quality.iter().all(|flag| flag.passed)
    }

    /// True if the run is finished, belongs to exactly this case, and was executed by this version: it need not be repeated
    /// then.
    pub fn is_result_of(&self, case: &Case, granum_version: &str) -> bool {
        self.status == RunStatus::Finished
            && self.case_digest == case.digest()
            && self.granum_version == granum_version
    }
}

fn null_is_nan<'de, D: Deserializer<'de>>(input: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(input)?.unwrap_or(f64::NAN))
}

/// Numbers by name where a null is NaN, which JSON cannot represent otherwise.
///
/// # Errors
/// If a value is neither a number nor a null.
pub fn nulls_are_nan<'de, D: Deserializer<'de>>(
    input: D,
) -> std::result::Result<BTreeMap<String, f64>, D::Error> {
    let map = BTreeMap::<String, Option<f64>>::deserialize(input)?;
    Ok(map.into_iter().map(|(name, value)| (name, value.unwrap_or(f64::NAN))).collect())
}
