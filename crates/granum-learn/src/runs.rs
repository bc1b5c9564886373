//! What a study remembers of the runs that it was trained and judged on, so that scores are called what they are.

use std::collections::BTreeMap;
use std::path::Path;

use granum_io::case::{CaseValues, Difference, SEED, differences};
use granum_io::run::file_digest;
use granum_io::{Run, RunSource};
use serde::{Deserialize, Serialize};

use crate::error::Result;

/// Key of [`StudyRun::values`] that says from which packing file a sample was made; it stands in no case file.
pub const PACKING: &str = "packing";
const NO_PACKING: &str = "none";

/// Files of a run that hold what networks learn from.
const LEARNED: [&str; 2] = ["series.parquet", "forces.parquet"];

/// What a run was for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunRole {
    /// Its states trained networks or were held out.
    Training,
    /// No network saw it.
    Unseen,
}

/// A run of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyRun {
    /// Last part of the name of its folder. (Not the whole: one study has one file wherever its runs lie.)
    pub name: String,
    /// What it was for.
    pub role: RunRole,
    /// The values of its case, and [`PACKING`].
    pub values: CaseValues,
    /// SHA-256 of the files that hold what networks learn from.
    pub content: BTreeMap<String, String>,
}

impl StudyRun {
    /// What a study remembers of a run.
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
        let digest = |name: &str| Ok((name.to_string(), file_digest(&run.path().join(name))?));
        Ok(StudyRun {
            name: last_part(run.path()),
            role,
            values,
            content: LEARNED.into_iter().map(digest).collect::<Result<_>>()?,
        })
    }

    /// True if the two hold the same test: the same states, or the same case with the same seed (one of them may have been
    /// ended before the other).
    pub fn is_same_test(&self, other: &StudyRun) -> bool {
        self.content == other.content || self.values == other.values
    }
}

/// In what named runs differ besides the seed of their samples.
pub fn differences_but_seed(runs: &[(&str, &StudyRun)]) -> Vec<Difference> {
    let cases: Vec<(&str, &CaseValues)> = runs.iter().map(|(name, run)| (*name, &run.values)).collect();
    differences(&cases).into_iter().filter(|found| found.key != SEED).collect()
}

/// The packing file that a sample was made of by where a run began, also where a test took the sample from another folder;
/// nothing where that folder is gone. (Records name their packing themselves; those of earlier versions did not.)
fn packing(source: &RunSource) -> Option<String> {
    match source {
        RunSource::Sample(folder) => {
            let sample = Run::at(folder).and_then(|run| run.record()).ok()?;
            // A sample is never made of another sample: folders that lead to each other would have no end.
            (!matches!(sample.source, RunSource::Sample(_))).then(|| packing(&sample.source))?
        }
        RunSource::Case => Some(NO_PACKING.to_string()),
        RunSource::Packing { sha256, .. } => Some(shown(sha256)),
    }
}

/// A packing as a value of a case.
fn shown(sha256: &str) -> String {
    format!("SHA-256 {sha256}")
}

fn last_part(path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    whole.file_name().map_or_else(|| whole.display().to_string(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_io::{Case, Machine, RunFolder, RunRecord};

    /// A folder of a run that began from somewhere.
    fn make(path: &Path, source: RunSource) -> Run {
        let folder = RunFolder::create(path, false).unwrap();
        let mut record = RunRecord::new("shear", "0.1.0", &Case::default(), Machine::here("avx2", 1));
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
