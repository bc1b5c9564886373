//! The files of a study: `study.json` with the definition, the runs, the scores and the SHA-256 of every other file; one file
//! for each surrogate, which is a surrogate file like any other; and `predictions.csv` with the predictions for the unseen runs.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use granum_core::{Table, digest, json};
use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::sealed::write_sealed;
use granum_io::shell::ShowPath;
use serde::{Deserialize, Serialize};

use super::definition::StudyDefinition;
use super::member::{Member, StudyFit};
use super::names::{SCORED_FILE, STUDY_FILE, member_file, old_paper_format};
use super::predictions::predictions;
use super::scores::StudyScores;
use super::training::Study;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::learning_curve::LearningCurve;
use crate::methods::networks::{KeptNetworks, TIMES_FILE};
use crate::runs::StudyRun;
use crate::surrogate::SurrogateMethods;
use crate::surrogate::file::{is_whole, sealed};

const FORMAT: &str = "granum surrogate study";
/// Version of the format. Version 1 had no settings of networks.
const VERSION: u64 = 2;
/// Format of the studies of the paper's networks of earlier versions.
const PAPER_FORMAT: &str = "granum study";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u64,
    granum_version: String,
    dataset_digest: String,
    definition: StudyDefinition,
    runs: Vec<StudyRun>,
    /// Names of the unseen runs in the order of their numbers in the predictions.
    unseen: Vec<String>,
    scores: StudyScores,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    learning_curve: Option<LearningCurve>,
    remarks: BTreeMap<String, Vec<String>>,
    /// SHA-256 of every other file of the study.
    files: BTreeMap<String, String>,
    #[serde(default, skip_serializing, rename = "sha256")]
    _digest: String,
}

#[derive(Deserialize)]
struct Header {
    format: Option<String>,
    version: Option<u64>,
}

/// A study with what was stored beside its surrogates.
pub struct StoredStudy {
    /// The study.
    pub study: Study,
    /// Its scores at the end of training.
    pub scores: StudyScores,
    /// Names of the unseen runs, whose numbers in the predictions count from 1.
    pub unseen: Vec<String>,
    /// The predictions for the unseen runs; `None` without unseen runs.
    pub predictions: Option<Table>,
}

/// True if a folder holds a finished study.
pub fn is_study(folder: &Path) -> bool {
    let text = granum_core::input::read_text(&folder.join(STUDY_FILE), granum_core::input::LARGEST_INPUT)
        .unwrap_or_default();
    serde_json::from_str::<Header>(&text).is_ok_and(|header| header.format.as_deref() == Some(FORMAT))
}

/// Writes a study with its scores and its predictions for the unseen runs of its data set. The files of the surrogates are
/// written first and `study.json` last.
///
/// # Errors
/// If a file cannot be written or an unseen run cannot be predicted.
pub fn save(folder: &Path, study: &Study, dataset: &Dataset) -> Result<StudyScores> {
    let scores = study.evaluate(dataset)?;
    let mut files = BTreeMap::new();
    for member in study.members() {
        let text = crate::surrogate::to_json(member.surrogate.as_ref())?;
        let name = member_file(&member.name);
        write_atomically(&folder.join(&name), |file| file.write_all(text.as_bytes()))?;
        files.insert(name, digest::sha256(text.as_bytes()));
    }
    let unseen = dataset.split(&study.definition.split)?.unseen;
    if unseen.rows() > 0 {
        let path = folder.join(SCORED_FILE);
        granum_io::write_table(&path, &predictions(study, &unseen)?)?;
        files.insert(SCORED_FILE.into(), granum_io::run::file_digest(&path)?);
    }
    if !study.seconds.is_empty() {
        write_sealed(&folder.join(TIMES_FILE), &study.seconds)?;
    }
    let remarks = study.fits.iter().filter(|fit| !fit.remarks.is_empty());
    let file = File {
        format: FORMAT.into(),
        version: VERSION,
        granum_version: env!("CARGO_PKG_VERSION").into(),
        dataset_digest: study.dataset_digest.clone(),
        definition: study.definition.clone(),
        runs: study.runs.clone(),
        unseen: unseen.runs().iter().map(|run| run.name().to_owned()).collect(),
        scores: scores.clone(),
        learning_curve: study.learning_curve.clone(),
        remarks: remarks.map(|fit| (fit.name.clone(), fit.remarks.clone())).collect(),
        files,
        _digest: String::new(),
    };
    let text = json::readable(&file).map_err(|error| LearnError::Content(error.to_string()))?;
    write_atomically(&folder.join(STUDY_FILE), |out| out.write_all(sealed(&text).as_bytes()))?;
    Ok(scores)
}

/// Reads a study from its folder.
///
/// # Errors
/// If a file is missing, was altered or is of a newer version; the message names the file.
pub fn load(folder: &Path, methods: &SurrogateMethods) -> Result<StoredStudy> {
    let path = folder.join(STUDY_FILE);
    let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
        .map_err(Error::file("read", &path))?;
    let file = opened(&text).map_err(|reason| wrong(&path, reason))?;
    for (name, sha256) in &file.files {
        check_file(folder, name, sha256)?;
    }
    let missing = |name: &str| wrong(&path, format!("it does not list the file of {name}"));
    let mut fits = Vec::new();
    for spec in &file.definition.fits {
        let name = spec.fit_name();
        let scored = file.scores.fits.iter().find(|fit| fit.name == name).ok_or_else(|| missing(&name))?;
        let member = |member: &super::MemberScores| {
            let own = member_file(&member.name);
            if !file.files.contains_key(&own) {
                return Err(missing(&member.name));
            }
            let (name, method) = (member.name.clone(), member.method.clone());
            Ok(Member { name, method, role: member.role, surrogate: methods.load(&folder.join(own))? })
        };
        let members = scored.members.iter().map(member).collect::<Result<_>>()?;
        let remarks = file.remarks.get(&name).cloned().unwrap_or_default();
        fits.push(StudyFit { name, spec: spec.clone(), members, remarks });
    }
    let predictions = match file.files.contains_key(SCORED_FILE) {
        true => Some(granum_io::read_table(folder.join(SCORED_FILE))?),
        false => None,
    };
    let (definition, dataset_digest, runs) = (file.definition, file.dataset_digest, file.runs);
    let seconds = KeptNetworks::times(folder);
    let learning_curve = file.learning_curve;
    let study = Study { definition, dataset_digest, runs, fits, seconds, learning_curve };
    Ok(StoredStudy { study, scores: file.scores, unseen: file.unseen, predictions })
}

/// The files of a study that are missing or are not those with which it was saved, with the reason.
///
/// # Errors
/// If `study.json` itself is missing, damaged or of another version; the message names it.
pub fn faults(folder: &Path) -> Result<Vec<LearnError>> {
    let path = folder.join(STUDY_FILE);
    let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
        .map_err(Error::file("read", &path))?;
    let file = opened(&text).map_err(|reason| wrong(&path, reason))?;
    Ok(file.files.iter().filter_map(|(name, sha256)| check_file(folder, name, sha256).err()).collect())
}

/// Refuses a file that is not the one with the given SHA-256.
fn check_file(folder: &Path, name: &str, sha256: &str) -> Result<()> {
    let stem = name.strip_suffix(".json").or_else(|| name.strip_suffix(".csv")).unwrap_or(name);
    granum_io::check_name("name of a file", stem)
        .map_err(|error| wrong(&folder.join(STUDY_FILE), error.to_string()))?;
    let own = folder.join(name);
    if granum_io::run::file_digest(&own)? == sha256 {
        return Ok(());
    }
    let reason = format!(
        "its SHA-256 is not the one that {STUDY_FILE} records: it was changed or replaced since the study was saved; put the \
         file back, or train again"
    );
    Err(wrong(&own, reason))
}

fn wrong(path: &Path, reason: String) -> LearnError {
    LearnError::SurrogateFile { file: path.shown(), reason }
}

fn opened(text: &str) -> std::result::Result<File, String> {
    let header: Header =
        serde_json::from_str(text).map_err(|error| format!("this is not a study: {error}"))?;
    match (header.format.as_deref(), header.version) {
        (Some(FORMAT), Some(1..=VERSION)) => {}
        (Some(FORMAT), Some(version)) => {
            return Err(format!("it has version {version}, this program reads versions up to {VERSION}"));
        }
        _ if old_paper_format(text, PAPER_FORMAT).is_some() => {
            return Err(format!(
                "it is a study of the paper's networks in version {} of an earlier format; this program reads studies in the \
                 format \"{FORMAT}\" up to version {VERSION}; train again with --force",
                old_paper_format(text, PAPER_FORMAT).unwrap_or_default()
            ));
        }
        (format, _) => {
            let found = format.unwrap_or("none");
            return Err(format!("\"format\" should be \"{FORMAT}\", found {found}"));
        }
    }
    if !is_whole(text) {
        return Err(
            "the SHA-256 does not match the content: the file was altered or damaged; train again".into()
        );
    }
    serde_json::from_str(text).map_err(|error| format!("not a usable study: {error}"))
}
