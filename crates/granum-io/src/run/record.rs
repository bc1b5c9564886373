//! What `run.json` says of a run.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Deserializer, Serialize};

use super::RUN_FORMAT;
use crate::case::Case;

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

/// Where the sample of a run came from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunSource {
    /// It was prepared as the case says.
    #[default]
    Case,
    /// It is the one that was left in this folder.
    Sample(PathBuf),
    /// A packing file.
    Packing {
        /// The file.
        file: PathBuf,
        /// SHA-256 of its bytes.
        sha256: String,
    },
}

/// The packing that the sample of a run is made of.
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

/// Name of granum's own engine, which records leave out.
pub const OWN_ENGINE: &str = "granum";

fn own_engine() -> String {
    OWN_ENGINE.to_string()
}

fn is_own_engine(engine: &str) -> bool {
    engine == OWN_ENGINE || engine.is_empty()
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
    /// Name of the engine that ran it.
    #[serde(default = "own_engine", skip_serializing_if = "is_own_engine")]
    pub engine: String,
    /// Seed of the sample; none if it is made of a packing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// [`Case::digest_with`] of the case and the packing.
    pub case_digest: String,
    /// [`Case::preparation_digest_with`] of the case and the packing.
    pub preparation_digest: String,
    /// The packing that the sample is made of, if it is, also where the run took a sample that was made of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub packing: Option<PackingRecord>,
    /// Where the sample came from.
    #[serde(default)]
    pub source: RunSource,
    /// The resolved case until `case.toml` is written: a run that is killed in between can be begun again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unwritten_case: Option<String>,
    /// What is under way in a run that did not reach its end, e.g. `compaction, trial 2`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub phase: String,
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
            engine: own_engine(),
            seed: Some(case.preparation.seed),
            case_digest: case.digest(),
            preparation_digest: case.preparation_digest(),
            grains: case.grains.count,
            machine,
            ..RunRecord::default()
        }
    }

    /// Says that the sample is made of a packing: its grains, no seed, and digests that cover it.
    pub fn set_packing(&mut self, case: &Case, packing: PackingRecord) {
        self.seed = None;
        self.grains = packing.grains;
        self.case_digest = case.digest_with(Some(&packing.sha256));
        self.preparation_digest = case.preparation_digest_with(Some(&packing.sha256));
        self.packing = Some(packing);
    }

    /// SHA-256 of the packing that the sample is made of.
    pub fn packing_digest(&self) -> Option<&str> {
        self.packing.as_ref().map(|packing| packing.sha256.as_str())
    }

    /// True if the run is of this whole case and of the packing that it names.
    pub fn is_of(&self, case: &Case) -> bool {
        self.case_digest == case.digest_with(self.packing_digest())
    }

    /// Product of grains and steps over all phases.
    pub fn grain_steps(&self) -> u64 {
        let steps = self.steps.values().fold(0u64, |sum, steps| sum.saturating_add(*steps));
        steps.saturating_mul(self.grains as u64)
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

/// Numbers by name where a null is NaN: JSON has no other way to say it.
///
/// # Errors
/// If a value is neither.
pub fn nulls_are_nan<'de, D: Deserializer<'de>>(
    input: D,
) -> std::result::Result<BTreeMap<String, f64>, D::Error> {
    let map = BTreeMap::<String, Option<f64>>::deserialize(input)?;
    Ok(map.into_iter().map(|(name, value)| (name, value.unwrap_or(f64::NAN))).collect())
}
