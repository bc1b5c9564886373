//! The description that a study stores of its runs for training and evaluation, so that later scores are labelled correctly.

use std::collections::BTreeMap;
use std::path::Path;

use granum_io::case::{CaseValues, Difference, SEED, differences};
use granum_io::run::file_digest;
use granum_io::shell::ShowPath;
use granum_io::{Case, Run, RunSource};
use serde::{Deserialize, Serialize};

use crate::error::Result;

/// Key of [`StudyRun::values`] for the packing file from which a sample was made; it does not occur in case files.
pub const PACKING: &str = "packing";
const NO_PACKING: &str = "none";

/// Files of a run with the data from which networks learn, beside those of further histograms.
const LEARNED: [&str; 2] = ["series.parquet", "forces.parquet"];

/// The role of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunRole {
    /// Its states were used for training or held out.
    Training,
    /// It was used neither for training nor for selection.
    Unseen,
}

impl RunRole {
    /// The role as one word.
    pub fn name(self) -> &'static str {
        match self {
            RunRole::Training => "training",
            RunRole::Unseen => "unseen",
        }
    }
}

/// A run of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyRun {
    /// Last component of the path of its folder. (The full path is omitted, so that the file does not depend on the
    /// location of the runs.)
    pub name: String,
    /// The role of the run.
    pub role: RunRole,
    /// The values of its case, and [`PACKING`].
    pub values: CaseValues,
    /// SHA-256 of the files with the data from which networks learn.
    pub content: BTreeMap<String, String>,
}

impl StudyRun {
    /// Reads the description of a run.
    ///
    /// # Errors
    /// If a file of the run cannot be read.
    pub fn read(run: &Run, role: RunRole) -> Result<StudyRun> {
        let mut values = run.case()?.values();
        let record = run.record()?;
        let packing = match record.packing_digest() {
            Some(sha256) => Some(shown(sha256)),
            None => packing(&record.source),
        };
        values.extend(packing.map(|packing| (PACKING.to_string(), packing)));
        let histograms = run.histograms()?.into_iter().map(|name| format!("histograms/{name}.parquet"));
        let files = LEARNED.map(String::from).into_iter().chain(histograms);
        let digest = |name: String| {
            let digest = file_digest(&run.path().join(&name))?;
            Ok((name, digest))
        };
        Ok(StudyRun {
            name: last_part(run.path()),
            role,
            values,
            content: files.map(digest).collect::<Result<_>>()?,
        })
    }

    /// The description of a run of which only the case, the packing of its sample and the digest of its results are known.
    pub fn of_case(name: &str, role: RunRole, case: &Case, packing: Option<&str>, digest: &str) -> StudyRun {
        let mut values = case.values();
        values.insert(PACKING.into(), packing.map_or_else(|| NO_PACKING.to_string(), shown));
        let content = BTreeMap::from([("digest".to_string(), digest.to_string())]);
        StudyRun { name: name.to_string(), role, values, content }
    }

    /// True if both are the same test: they have the same states, or the same case with the same seed (one of them may
    /// have been ended earlier than the other).
    pub fn is_same_test(&self, other: &StudyRun) -> bool {
        self.content == other.content || self.values == other.values
    }
}

/// The differences between named runs other than the seed of their samples.
pub fn differences_but_seed(runs: &[(&str, &StudyRun)]) -> Vec<Difference> {
    let cases: Vec<(&str, &CaseValues)> = runs.iter().map(|(name, run)| (*name, &run.values)).collect();
    differences(&cases).into_iter().filter(|found| found.key != SEED).collect()
}

/// The packing file from which a sample was made, derived from the source of the run, even if a test took the sample from
/// another folder; `None` if that folder no longer exists. (Records now name their packing themselves, but those of earlier
/// versions did not.)
fn packing(source: &RunSource) -> Option<String> {
    match source {
        RunSource::Sample(folder) => {
            let sample = Run::at(folder).and_then(|run| run.record()).ok()?;
            // A sample is never made from another sample, and folders that refer to each other would give an endless
            // recursion.
            (!matches!(sample.source, RunSource::Sample(_))).then(|| packing(&sample.source))?
        }
        RunSource::Case => Some(NO_PACKING.to_string()),
        RunSource::Packing { sha256, .. } => Some(shown(sha256)),
    }
}

/// A packing in the form of a value of a case.
fn shown(sha256: &str) -> String {
    format!("SHA-256 {sha256}")
}

fn last_part(path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    whole.file_name().map_or_else(|| whole.shown(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_io::{Machine, RunFolder, RunKind, RunRecord};

    /// Creates the folder of a run with the given source.
    fn make(path: &Path, source: RunSource) -> Run {
        let folder = RunFolder::create(path, false).unwrap();
        let mut record = RunRecord::new(RunKind::Test, "0.1.0", &Case::default(), Machine::here("avx2", 1));
        record.source = source;
        folder.write_record(&record).unwrap();
        folder.run()
    }

    #[test]
    fn the_packing_is_found_also_behind_a_sample_folder() {
        let base = tempfile::tempdir().unwrap();
        let at = |name: &str| base.path().join(name);
        let packed = RunSource::Packing { file: "p.csv".into(), sha256: "ab".into() };
        make(&at("packed"), packed.clone());
        make(&at("placed"), RunSource::Case);
        make(&at("taken"), RunSource::Sample(at("taken")));
        assert_eq!(packing(&packed).as_deref(), Some("SHA-256 ab"));
        assert_eq!(packing(&RunSource::Case).as_deref(), Some("none"));
        let behind = |name: &str| packing(&RunSource::Sample(at(name)));
        assert_eq!(behind("packed").as_deref(), Some("SHA-256 ab"));
        assert_eq!(behind("placed").as_deref(), Some("none"));
        assert_eq!((behind("taken"), behind("gone")), (None, None));
    }

    #[test]
    fn runs_differ_by_their_packing_and_not_by_their_seed() {
        let run = |seed: u64, packing: &str| {
            let mut case = Case::default();
            case.preparation.seed = seed;
            let mut values = case.values();
            values.insert(PACKING.into(), packing.into());
            StudyRun { name: "run".into(), role: RunRole::Training, values, content: BTreeMap::new() }
        };
        let (one, two, packed) = (run(1, "none"), run(2, "none"), run(1, "SHA-256 ab"));
        assert!(differences_but_seed(&[("one", &one), ("two", &two)]).is_empty());
        let found = differences_but_seed(&[("one", &one), ("two", &two), ("packed", &packed)]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].to_string(), "packing: none in one, two; SHA-256 ab in packed");
    }

    #[test]
    fn the_same_test_is_known_by_its_states_or_by_case_and_seed() {
        let values = Case::default().values();
        let run = |hash: &str, friction: &str| {
            let mut values = values.clone();
            values.insert("grains.material.friction".into(), friction.into());
            let content = BTreeMap::from([("series.parquet".to_string(), hash.to_string())]);
            StudyRun { name: "run".into(), role: RunRole::Training, values, content }
        };
        assert!(run("a", "0.3").is_same_test(&run("a", "0.5")));
        assert!(run("a", "0.3").is_same_test(&run("b", "0.3")));
        assert!(!run("a", "0.3").is_same_test(&run("b", "0.5")));
    }
}
