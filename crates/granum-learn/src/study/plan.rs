//! The plan of a training, which is written before anything is fitted, so that an interrupted training can be resumed.

use std::io::Write;
use std::path::{Path, PathBuf};

use granum_core::json;
use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::shell::ShowPath;
use serde::{Deserialize, Serialize};

use super::definition::StudyDefinition;
use super::files::{SCORED_FILE, STUDY_FILE, member_file};
use crate::error::{LearnError, Result};

/// File with the plan of a training.
pub const PLAN_FILE: &str = "training.json";
const FORMAT: &str = "granum surrogate training";

/// The plan of a training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyPlan {
    format: String,
    version: u64,
    granum_version: String,
    /// Folders of the training runs.
    pub runs: Vec<PathBuf>,
    /// Folders of the unseen runs.
    pub unseen: Vec<PathBuf>,
    /// SHA-256 of the data set.
    pub dataset_digest: String,
    /// What the study consists of.
    pub definition: StudyDefinition,
}

impl StudyPlan {
    /// A plan of this version, with absolute paths.
    pub fn new(
        runs: &[PathBuf],
        unseen: &[PathBuf],
        dataset_digest: String,
        definition: StudyDefinition,
    ) -> StudyPlan {
        let whole = |paths: &[PathBuf]| -> Vec<PathBuf> {
            paths.iter().map(|path| std::path::absolute(path).unwrap_or_else(|_| path.clone())).collect()
        };
        StudyPlan {
            format: FORMAT.into(),
            version: 1,
            granum_version: env!("CARGO_PKG_VERSION").into(),
            runs: whole(runs),
            unseen: whole(unseen),
            dataset_digest,
            definition,
        }
    }

    /// True if a folder holds the plan of such a training (and not that of the paper, whose file has the same name).
    pub fn is_in(folder: &Path) -> bool {
        #[derive(Deserialize)]
        struct Header {
            format: String,
        }
        let text = granum_core::input::read_text(&folder.join(PLAN_FILE), granum_core::input::LARGEST_INPUT)
            .unwrap_or_default();
        serde_json::from_str::<Header>(&text).is_ok_and(|header| header.format == FORMAT)
    }

    /// Reads the plan in a folder.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(folder: &Path) -> Result<StudyPlan> {
        let path = folder.join(PLAN_FILE);
        let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
            .map_err(Error::file("read", &path))?;
        serde_json::from_str(&text).map_err(|error| LearnError::SurrogateFile {
            file: path.shown(),
            reason: format!("not a usable plan of a training: {error}"),
        })
    }

    /// Writes the plan.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let text = json::readable(self).map_err(|error| LearnError::Content(error.to_string()))?;
        write_atomically(&folder.join(PLAN_FILE), |file| writeln!(file, "{}", text.trim_end()))?;
        Ok(())
    }

    /// What differs between two plans, in words.
    pub fn differences(&self, other: &StudyPlan) -> Vec<&'static str> {
        let (a, b) = (&self.definition, &other.definition);
        let mut found = Vec::new();
        let mut note = |differs: bool, what| {
            if differs {
                found.push(what);
            }
        };
        note(self.granum_version != other.granum_version, "the version of granum");
        note(self.dataset_digest != other.dataset_digest, "the runs");
        note(a.fits != b.fits, "inputs, outputs, coordinate or seed");
        note(a.methods != b.methods, "the methods");
        note(a.split != b.split || a.level != b.level, "the split");
        found
    }

    /// The files of the surrogates.
    pub fn surrogates(&self) -> Vec<String> {
        let fits = self.definition.fits.iter();
        fits.flat_map(|fit| self.definition.members(fit)).map(|member| member_file(&member.name)).collect()
    }

    /// All files that the training writes.
    pub fn files(&self) -> Vec<String> {
        let others = [PLAN_FILE, STUDY_FILE, SCORED_FILE].map(String::from);
        self.surrogates().into_iter().chain(others).collect()
    }
}
