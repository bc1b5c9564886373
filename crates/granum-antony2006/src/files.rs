//! The files of a study.
//!
//! A study is a folder: `study.json` describes the networks and their training runs, and each network has its own model
//! file, `F1-1.json` to `F6-3.json` and `F1-strain-only-1.json` to `F6-strain-only-3.json`. `baselines.json` contains the
//! baselines.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use granum_io::Error;
use granum_nets::Model;
use serde::{Deserialize, Serialize};

use crate::baseline::Baselines;
use crate::layout::{
    BASELINES_FILE, STUDY_FILE, TIMES_FILE, check_mapping, network_file, read_json, write_json,
};
use crate::mapping::{Form, Mapping};
use crate::mapping_networks::MappingNetworks;
use crate::study::{Study, TrainedMapping, network_name};
use crate::training_checkpoints::TrainingCheckpoints;
use granum_learn::runs::StudyRun;
use granum_learn::{LearnError, Result};

const FORMAT: &str = "granum study";
/// Version of the format. Version 1 did not record the runs of a study; up to version 2 there was no SHA-256, neither of the file
/// nor of the networks and baselines.
const VERSION: u64 = 3;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StudyFile {
    format: String,
    version: u64,
    form: Form,
    trainer: String,
    seed: u64,
    dataset_hash: String,
    /// The runs for training and evaluation; `None` in files of version 1.
    #[serde(default)]
    runs: Option<Vec<StudyRun>>,
    /// Centres of the bins of f.
    forces: Vec<f64>,
    bin_width: f64,
    mappings: Vec<MappingFile>,
    /// SHA-256 of the files of the networks and of the baselines, by name.
    #[serde(default)]
    content: BTreeMap<String, String>,
}

impl StudyFile {
    /// The names of the files of the study, those of its networks first.
    fn files(&self) -> Vec<String> {
        let names = self.mappings.iter().flat_map(|entry| {
            let count = entry.mapping.sub_models.len();
            let name = |strain_only, k| network_file(&network_name(&entry.mapping, strain_only, k));
            (0..count).flat_map(move |k| [name(false, k), name(true, k)]).collect::<Vec<_>>()
        });
        names.chain([BASELINES_FILE.to_string()]).collect()
    }

    /// Refuses a file of the study that is not the one with which the study was saved.
    fn check(&self, folder: &Path, name: &str) -> Result<()> {
        let path = folder.join(name);
        let Some(sha256) = self.content.get(name) else {
            if self.version < 3 || name == BASELINES_FILE {
                return Ok(());
            }
            return Err(Error::content(
                &folder.join(STUDY_FILE),
                format!("has no SHA-256 of {name}; train it again"),
            )
            .into());
        };
        if granum_io::run::file_digest(&path)? == *sha256 {
            return Ok(());
        }
        let message = format!(
            "was changed or replaced since the study was saved: {STUDY_FILE} has another SHA-256 of it; put the file back, or \
             train the study again"
        );
        Err(Error::content(&path, message).into())
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MappingFile {
    mapping: Mapping,
    /// Only in files of earlier versions; the times are now in a separate file, so that this one is reproducible byte by
    /// byte.
    #[serde(default, skip_serializing)]
    training_seconds: Vec<f64>,
    #[serde(default, skip_serializing)]
    strain_only_training_seconds: Vec<f64>,
}

/// Writes a study to an existing folder, with the runs for training and evaluation.
///
/// # Errors
/// If a file cannot be written.
pub fn save_study(folder: &Path, study: &Study, runs: &[StudyRun]) -> Result<()> {
    for trained in &study.mappings {
        for (surrogate, strain_only) in [(&trained.surrogate, false), (&trained.strain_only, true)] {
            for (k, model) in surrogate.networks().iter().enumerate() {
                // Both surrogates have the name of the mapping.
                let name = network_name(surrogate.mapping(), strain_only, k);
                let failed = |error: granum_nets::ModelError| network_error(&name, &error);
                model.save(&folder.join(network_file(&name))).map_err(failed)?;
            }
        }
    }
    let mut file = StudyFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        form: study.form,
        trainer: study.trainer.clone(),
        seed: study.seed,
        dataset_hash: study.dataset_hash.clone(),
        runs: Some(runs.to_vec()),
        forces: study.forces.clone(),
        bin_width: study.bin_width,
        mappings: study
            .mappings
            .iter()
            .map(|trained| MappingFile {
                mapping: trained.surrogate.mapping().clone(),
                training_seconds: Vec::new(),
                strain_only_training_seconds: Vec::new(),
            })
            .collect(),
        content: BTreeMap::new(),
    };
    if let Some(baselines) = &study.baselines {
        write_json(&folder.join(BASELINES_FILE), baselines)?;
    }
    for name in file.files() {
        if name != BASELINES_FILE || study.baselines.is_some() {
            let digest = granum_io::run::file_digest(&folder.join(&name))?;
            file.content.insert(name, digest);
        }
    }
    write_json(&folder.join(TIMES_FILE), &seconds_of(study))?;
    write_json(&folder.join(STUDY_FILE), &file)
}

/// Training times of all networks by name, s.
fn seconds_of(study: &Study) -> BTreeMap<String, f64> {
    let mut all = BTreeMap::new();
    for trained in &study.mappings {
        let mapping = trained.surrogate.mapping();
        for (strain_only, seconds) in [(false, &trained.seconds), (true, &trained.strain_only_seconds)] {
            for (k, seconds) in seconds.iter().enumerate() {
                all.insert(network_name(mapping, strain_only, k), *seconds);
            }
        }
    }
    all
}

/// Reads a study from its folder.
///
/// # Errors
/// If a file is missing, damaged or of a newer version; the message names the file.
pub fn load_study(folder: &Path) -> Result<Study> {
    let path = folder.join(STUDY_FILE);
    let file = read_study_file(&path)?;
    let mut mappings = Vec::new();
    for entry in &file.mappings {
        check_mapping(&path, &entry.mapping)?;
        let load = |mapping: Mapping, strain_only: bool| -> Result<MappingNetworks> {
            let models = (0..mapping.sub_models.len()).map(|k| {
                let name = network_name(&mapping, strain_only, k);
                file.check(folder, &network_file(&name))?;
                Model::load(&folder.join(network_file(&name))).map_err(|error| network_error(&name, &error))
            });
            let models = models.collect::<Result<Vec<_>>>()?;
            MappingNetworks::new(mapping, file.form, file.forces.clone(), models)
        };
        mappings.push(TrainedMapping {
            surrogate: load(entry.mapping.clone(), false)?,
            strain_only: load(entry.mapping.strain_only(), true)?,
            seconds: padded(&entry.training_seconds, entry.mapping.sub_models.len()),
            strain_only_seconds: padded(&entry.strain_only_training_seconds, entry.mapping.sub_models.len()),
        });
    }
    file.check(folder, BASELINES_FILE)?;
    // Baselines that the study was not saved with are not its own.
    let has_baselines = file.version < 3 || file.content.contains_key(BASELINES_FILE);
    let mut study = Study {
        form: file.form,
        trainer: file.trainer,
        seed: file.seed,
        dataset_hash: file.dataset_hash,
        forces: file.forces,
        bin_width: file.bin_width,
        mappings,
        baselines: None,
    };
    if has_baselines {
        study.baselines = load_baselines(folder, &study)?;
    }
    TrainingCheckpoints::new(folder, Duration::MAX).add_seconds(&mut study);
    Ok(study)
}

/// The baselines of a study; `None` if it was written by a version that did not store them.
fn load_baselines(folder: &Path, study: &Study) -> Result<Option<Baselines>> {
    let path = folder.join(BASELINES_FILE);
    if !path.exists() {
        return Ok(None);
    }
    let text = read_json(&path, 0)?;
    let baselines: Baselines = serde_json::from_str(&text).map_err(|error| {
        Error::content(&path, format!("these are not baselines: {error}; train it again"))
    })?;
    let mappings = study.mappings.iter().map(|trained| trained.surrogate.mapping());
    if !baselines.are_of(mappings, study.forces.len()) {
        let message = "these are not the baselines of the mappings in study.json; train it again";
        return Err(Error::content(&path, message).into());
    }
    Ok(Some(baselines))
}

/// The runs with which the study in a folder was trained and evaluated; `None` if it was written by a version that did not
/// record them.
///
/// # Errors
/// If `study.json` is missing, damaged or of a newer version; the message names it.
pub fn load_runs(folder: &Path) -> Result<Option<Vec<StudyRun>>> {
    Ok(read_study_file(&folder.join(STUDY_FILE))?.runs)
}

/// The files of a study that are missing or are not those with which it was saved, with the reason.
///
/// # Errors
/// If `study.json` itself is missing, damaged or of a newer version; the message names it.
pub fn faults(folder: &Path) -> Result<Vec<LearnError>> {
    let path = folder.join(STUDY_FILE);
    let file = read_study_file(&path)?;
    file.mappings.iter().try_for_each(|entry| check_mapping(&path, &entry.mapping))?;
    Ok(file.files().iter().filter_map(|name| file.check(folder, name).err()).collect())
}

/// True if `study.json` holds the SHA-256 of the other files; those of earlier versions cannot be checked.
///
/// # Errors
/// As [`faults`].
pub fn can_be_checked(folder: &Path) -> Result<bool> {
    Ok(read_study_file(&folder.join(STUDY_FILE))?.version >= 3)
}

fn read_study_file(path: &Path) -> Result<StudyFile> {
    let text = read_json(path, 3)?;
    let file: StudyFile = serde_json::from_str(&text)
        .map_err(|error| Error::content(path, format!("this is not a study: {error}; train it again")))?;
    if file.format != FORMAT || !(1..=VERSION).contains(&file.version) {
        let found = format!("format \"{}\" version {}", file.format, file.version);
        let wanted = format!("this program reads \"{FORMAT}\" up to version {VERSION}");
        return Err(Error::content(path, format!("{found}, but {wanted}")).into());
    }
    Ok(file)
}

/// Training times of all sub-models, s; 0 if the file has none.
fn padded(seconds: &[f64], count: usize) -> Vec<f64> {
    (0..count).map(|k| seconds.get(k).copied().unwrap_or(0.0)).collect()
}

fn network_error(name: &str, error: &granum_nets::ModelError) -> LearnError {
    LearnError::Network { network: name.to_owned(), reason: error.to_string() }
}
