//! The plan of a training, which is written before anything is fitted, so that an interrupted training can be resumed.

use std::path::{Path, PathBuf};

use granum_io::Error;
use granum_io::sealed::{unseal_strictly, write_sealed};
use granum_io::shell::ShowPath;
use granum_io::{moved_with, path_from, path_in, recordable};
use serde::{Deserialize, Serialize};

use super::definition::StudyDefinition;
use super::names::{Head, SCORED_FILE, STUDY_FILE, member_file, network_files, old_paper_format};
use crate::error::{LearnError, Result};
use crate::methods::networks::TIMES_FILE;
use crate::surrogate::FitSpec;

/// File with the plan of a training.
pub const PLAN_FILE: &str = "training.json";
const FORMAT: &str = "granum surrogate training";
/// Version of the format. Version 1 had no settings of networks and no SHA-256.
const VERSION: u64 = 2;

/// Format of the plans of earlier versions for the networks of the paper.
const PAPER_FORMAT: &str = "granum training";

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
    /// The share of the training runs that are kept unseen as whole runs; 0 for none.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub unseen_share: f64,
    /// True if the runs may differ in more than the seed of their samples although no input tells of it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixed: bool,
}

/// Where a run is that the plan in a folder names. Earlier versions wrote absolute paths; if the run is gone from there, it was moved with
/// the folder.
fn place(folder: &Path, run: &Path) -> PathBuf {
    let named = path_in(folder, run);
    if !run.is_absolute() || named.exists() {
        return named;
    }
    moved_with(folder, run, &|place| place.exists()).unwrap_or(named)
}

fn is_nothing(share: &f64) -> bool {
    *share == 0.0
}

impl StudyPlan {
    /// A plan of this version, with absolute paths in memory.
    ///
    /// # Errors
    /// If the working directory, to which relative paths refer, no longer exists, or a path is not UTF-8 text.
    pub fn new(
        runs: &[PathBuf],
        unseen: &[PathBuf],
        dataset_digest: String,
        definition: StudyDefinition,
    ) -> Result<StudyPlan> {
        let absolute = |paths: &[PathBuf]| -> Result<Vec<PathBuf>> {
            Ok(paths.iter().map(|path| recordable(path)).collect::<std::result::Result<_, _>>()?)
        };
        Ok(StudyPlan {
            format: FORMAT.into(),
            version: VERSION,
            granum_version: env!("CARGO_PKG_VERSION").into(),
            runs: absolute(runs)?,
            unseen: absolute(unseen)?,
            dataset_digest,
            definition,
            unseen_share: 0.0,
            mixed: false,
        })
    }

    /// True if a folder holds the plan of such a training (and not that of the paper, whose file has the same name).
    pub fn is_in(folder: &Path) -> bool {
        let text = granum_core::input::read_text(&folder.join(PLAN_FILE), granum_core::input::LARGEST_INPUT)
            .unwrap_or_default();
        serde_json::from_str::<Head>(&text).is_ok_and(|head| head.format == FORMAT)
    }

    /// Reads the plan in a folder.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(folder: &Path) -> Result<StudyPlan> {
        let path = folder.join(PLAN_FILE);
        let wrong = |reason: String| LearnError::SurrogateFile { file: path.shown(), reason };
        let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
            .map_err(Error::file("read", &path))?;
        if let Some(found) = old_paper_format(&text, PAPER_FORMAT) {
            return Err(wrong(format!(
                "it is the plan of a training of the paper's networks in version {found} of an earlier format; this program \
                 continues \"{FORMAT}\" up to version {VERSION}; train again with --force"
            )));
        }
        let head: Head = serde_json::from_str(&text)
            .map_err(|error| wrong(format!("not a usable plan of a training: {error}")))?;
        if head.format != FORMAT || !(1..=VERSION).contains(&head.version) {
            let (format, version) = (head.format, head.version);
            return Err(wrong(format!(
                "format \"{format}\" version {version}, but this program reads \"{FORMAT}\" up to version {VERSION}"
            )));
        }
        let text = if head.version >= 2 { unseal_strictly(&path, &text)? } else { text };
        let mut plan: StudyPlan = serde_json::from_str(&text)
            .map_err(|error| wrong(format!("not a usable plan of a training: {error}")))?;
        for run in plan.runs.iter_mut().chain(&mut plan.unseen) {
            *run = place(folder, run);
        }
        for name in plan.names() {
            granum_io::check_name("name of a surrogate", &name).map_err(|error| wrong(error.to_string()))?;
        }
        Ok(plan)
    }

    /// Writes the plan. It names the runs relative to its folder, so that folders that are moved together find each other again.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let named = |paths: &[PathBuf]| -> std::result::Result<Vec<PathBuf>, Error> {
            paths.iter().map(|path| path_from(folder, path)).collect()
        };
        let plan = StudyPlan { runs: named(&self.runs)?, unseen: named(&self.unseen)?, ..self.clone() };
        Ok(write_sealed(&folder.join(PLAN_FILE), &plan)?)
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
        let seeds = |d: &StudyDefinition| d.fits.iter().map(|fit| fit.seed).collect::<Vec<_>>();
        let unseeded = |d: &StudyDefinition| -> Vec<FitSpec> {
            let plain = |fit: &FitSpec| FitSpec { threads: 0, kept_as: None, seed: 0, ..fit.clone() };
            d.fits.iter().map(plain).collect()
        };
        note(unseeded(a) != unseeded(b), "inputs, outputs, coordinate or sub-models");
        note(seeds(a) != seeds(b), "seed");
        note(a.methods != b.methods, "the methods");
        note(a.networks.trainer != b.networks.trainer, "trainer");
        note(a.networks.form != b.networks.form, "form");
        note(a.networks.epoch_factor != b.networks.epoch_factor, "epoch factor");
        note(a.networks.hidden != b.networks.hidden, "the sizes of networks");
        note(a.learning_curve != b.learning_curve, "the learning curve");
        note(a.most_states != b.most_states, "the number of training states");
        let shares = self.unseen_share != other.unseen_share;
        note(a.split != b.split || a.level != b.level || shares, "the split");
        found
    }

    /// The names of the surrogates.
    pub fn names(&self) -> Vec<String> {
        let fits = self.definition.fits.iter();
        fits.flat_map(|fit| self.definition.members(fit)).map(|member| member.name).collect()
    }

    /// The files of the surrogates.
    pub fn surrogates(&self) -> Vec<String> {
        self.names().iter().map(|name| member_file(name)).collect()
    }

    /// All files of the training that a folder holds or will hold, starting with the one that marks its end.
    pub fn files_in(&self, folder: &Path) -> Vec<String> {
        let others = [STUDY_FILE, PLAN_FILE, SCORED_FILE, TIMES_FILE].map(String::from).into_iter();
        others.chain(self.surrogates()).chain(network_files(folder, &self.names())).collect()
    }
}
