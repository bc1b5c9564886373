//! Checkpoints of a training: each network is stored when it is trained, the state of unfinished networks at intervals,
//! and the manifest describes the training, so that it can be resumed from its folder alone.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::recordable;
use granum_nets::Model;
use granum_nets::trainer::TrainerState;
use serde::{Deserialize, Serialize};

use crate::layout::{
    BASELINES_FILE, PLAN_FILE, STUDY_FILE, TIMES_FILE, check_mapping, network_file, read_json, write_json,
};
use crate::mapping::{Form, Mapping};
use crate::study::{Study, StudyOptions, network_name};
use granum_learn::{LearnError, Result};

const FORMAT: &str = "granum training";
/// Version of the format. Version 1 had no SHA-256.
const VERSION: u64 = 2;

/// The manifest of a training: its runs, data and options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingManifest {
    format: String,
    version: u64,
    granum_version: String,
    /// Run folders for training, as absolute paths.
    pub runs: Vec<PathBuf>,
    /// Run folders for evaluation.
    pub unseen: Vec<PathBuf>,
    /// True if the runs may differ in more than the seed of their samples.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixed: bool,
    /// See [`crate::StudyData::hash`].
    pub dataset_hash: String,
    /// Form in which the force distribution enters the networks.
    pub form: Form,
    /// Name of the trainer.
    pub trainer: String,
    /// See [`StudyOptions`].
    pub epoch_factor: f64,
    /// Seed of the study.
    pub seed: u64,
    /// The mappings.
    pub mappings: Vec<Mapping>,
}

impl TrainingManifest {
    /// The manifest of a study on runs.
    ///
    /// # Errors
    /// If the working directory, to which relative paths refer, no longer exists, or a path is not UTF-8 text.
    pub fn new(
        runs: &[PathBuf],
        unseen: &[PathBuf],
        dataset_hash: String,
        options: &StudyOptions,
    ) -> Result<TrainingManifest> {
        let absolute = |paths: &[PathBuf]| -> Result<Vec<PathBuf>> {
            Ok(paths.iter().map(|path| recordable(path)).collect::<std::result::Result<_, _>>()?)
        };
        Ok(TrainingManifest {
            format: FORMAT.into(),
            version: VERSION,
            granum_version: env!("CARGO_PKG_VERSION").into(),
            runs: absolute(runs)?,
            unseen: absolute(unseen)?,
            mixed: false,
            dataset_hash,
            form: options.form,
            trainer: options.trainer.name().to_owned(),
            epoch_factor: options.epoch_factor,
            seed: options.seed,
            mappings: options.mappings.clone(),
        })
    }

    /// Writes the file to a folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(PLAN_FILE), self)
    }

    /// Reads the file of a folder.
    ///
    /// # Errors
    /// If the file is missing, damaged or of another version.
    pub fn read(folder: &Path) -> Result<TrainingManifest> {
        let path = folder.join(PLAN_FILE);
        let text = read_json(&path, 2)?;
        let plan: TrainingManifest = serde_json::from_str(&text)
            .map_err(|error| Error::content(&path, format!("this is not a training manifest: {error}")))?;
        if plan.format != FORMAT || !(1..=VERSION).contains(&plan.version) {
            let found = format!("format \"{}\" version {}", plan.format, plan.version);
            let wanted = format!("this program reads \"{FORMAT}\" up to version {VERSION}");
            return Err(Error::content(&path, format!("{found}, but {wanted}")).into());
        }
        plan.mappings.iter().try_for_each(|mapping| check_mapping(&path, mapping))?;
        Ok(plan)
    }

    /// The differences that would lead to other networks; empty if both trainings are the same, independently of the
    /// location of their runs.
    pub fn differences(&self, other: &TrainingManifest) -> Vec<&'static str> {
        [
            (self.dataset_hash != other.dataset_hash, "runs"),
            (self.form != other.form, "form"),
            (self.trainer != other.trainer, "trainer"),
            (self.epoch_factor != other.epoch_factor, "epoch factor"),
            (self.seed != other.seed, "seed"),
            (self.mappings != other.mappings, "mappings"),
            (self.granum_version != other.granum_version, "granum version"),
        ]
        .into_iter()
        .filter_map(|(differs, name)| differs.then_some(name))
        .collect()
    }

    /// All files that the training may write, starting with the one that marks its end.
    pub fn files(&self) -> Vec<String> {
        let mut names = [STUDY_FILE, PLAN_FILE, TIMES_FILE, BASELINES_FILE].map(String::from).to_vec();
        names.extend(self.names().iter().flat_map(|name| [network_file(name), state_file(name)]));
        names
    }

    /// Files of all networks.
    pub fn networks(&self) -> Vec<String> {
        self.names().iter().map(|name| network_file(name)).collect()
    }

    fn names(&self) -> Vec<String> {
        let of = |mapping: &Mapping| {
            let names = |k| [false, true].map(|strain_only| network_name(mapping, strain_only, k));
            (0..mapping.sub_models.len()).flat_map(names).collect::<Vec<_>>()
        };
        self.mappings.iter().flat_map(of).collect()
    }
}

/// File with the state of an unfinished network.
fn state_file(network: &str) -> String {
    format!("{network}.unfinished")
}

/// Every file that [`TrainingCheckpoints`] of networks of these names may write to their folder, also one that a killed process
/// left half-written.
pub fn files_of_networks(names: &[String]) -> Vec<String> {
    let of = |name: &String| {
        let network = network_file(name);
        [format!("{network}.part"), network, state_file(name)]
    };
    names.iter().flat_map(of).chain([TIMES_FILE.to_string()]).collect()
}

/// Stores networks and the states of unfinished networks in a folder.
pub struct TrainingCheckpoints {
    folder: PathBuf,
    every: Duration,
    held: Mutex<Held>,
    failed: AtomicBool,
}

#[derive(Default)]
struct Held {
    seconds: BTreeMap<String, f64>,
    /// The time at which the state of each unfinished network was last stored.
    kept: BTreeMap<String, Instant>,
    failure: Option<LearnError>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UnderWay {
    /// Identifies the training.
    key: String,
    state: TrainerState,
}

impl TrainingCheckpoints {
    /// Stores networks in an existing folder, and the states of unfinished networks at the given interval.
    pub fn new(folder: &Path, every: Duration) -> TrainingCheckpoints {
        let seconds = read_json(&folder.join(TIMES_FILE), 0).ok();
        // The times do not affect any result, so that a damaged file is simply replaced.
        let seconds = seconds.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
        TrainingCheckpoints {
            folder: folder.to_path_buf(),
            every,
            held: Mutex::new(Held { seconds, ..Held::default() }),
            failed: AtomicBool::new(false),
        }
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn note(&self, result: Result<()>) {
        if let Err(error) = result {
            self.failed.store(true, Ordering::Relaxed);
            self.held().failure.get_or_insert(error);
        }
    }

    /// True after a file could not be written; training should then stop, since its results would be lost.
    pub fn failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// The error of the file that could not be written, if there is one.
    pub fn take_failure(&self) -> Option<LearnError> {
        self.held().failure.take()
    }

    /// Called when a network has been trained, or found finished (then `seconds` is zero).
    pub fn trained(&self, network: &str, model: &Model, seconds: f64) {
        if seconds > 0.0 {
            self.note(self.write_trained(network, model, seconds));
        }
        // A state may be left even next to a finished network if the process was killed between the two operations.
        let state = self.folder.join(state_file(network));
        if state.exists() {
            self.note(std::fs::remove_file(&state).map_err(|e| Error::file("remove", &state)(e).into()));
        }
    }

    fn write_trained(&self, network: &str, model: &Model, seconds: f64) -> Result<()> {
        let failed = |e: granum_nets::ModelError| LearnError::Network {
            network: network.into(),
            reason: e.to_string(),
        };
        model.save(&self.folder.join(network_file(network))).map_err(failed)?;
        let mut held = self.held();
        held.seconds.insert(network.to_string(), seconds);
        write_json(&self.folder.join(TIMES_FILE), &held.seconds)
    }

    /// The finished network of the given name, if it exists and can be read.
    pub fn finished(&self, network: &str) -> Option<Model> {
        Model::load(&self.folder.join(network_file(network))).ok()
    }

    /// True if the state of an unfinished network is due to be stored.
    pub fn is_due(&self, network: &str) -> bool {
        let mut held = self.held();
        match held.kept.get(network) {
            Some(last) => last.elapsed() > self.every,
            None => {
                held.kept.insert(network.to_string(), Instant::now());
                self.every.is_zero()
            }
        }
    }

    /// Stores the state of an unfinished network.
    pub fn under_way(&self, network: &str, key: &str, state: &TrainerState) {
        self.held().kept.insert(network.to_string(), Instant::now());
        self.note(self.write_state(network, UnderWay { key: key.to_string(), state: state.clone() }));
    }

    fn write_state(&self, network: &str, under_way: UnderWay) -> Result<()> {
        let path = self.folder.join(state_file(network));
        let text = serde_json::to_string(&under_way)
            .map_err(|error| LearnError::Network { network: network.into(), reason: error.to_string() })?;
        let sum = crc32fast::hash(text.as_bytes());
        write_atomically(&path, |file| write!(file, "{sum:08x}\n{text}\n"))?;
        Ok(())
    }

    /// The state of an unfinished network, if it is complete and belongs to the same training; otherwise `None`, and the
    /// network is trained from the start.
    pub fn state(&self, network: &str, key: &str) -> Option<TrainerState> {
        let text = granum_core::input::read_text(
            &self.folder.join(state_file(network)),
            granum_core::input::LARGEST_INPUT,
        )
        .ok()?;
        let (sum, text) = text.split_once('\n')?;
        let text = text.strip_suffix('\n')?;
        if u32::from_str_radix(sum, 16).ok()? != crc32fast::hash(text.as_bytes()) {
            return None;
        }
        let under_way: UnderWay = serde_json::from_str(text).ok()?;
        (under_way.key == key).then_some(under_way.state)
    }

    /// Adds to a study the training times of those networks that were found finished.
    pub fn add_seconds(&self, study: &mut Study) {
        let held = self.held();
        for trained in &mut study.mappings {
            let mapping = trained.surrogate.mapping().clone();
            for (strain_only, seconds) in
                [(false, &mut trained.seconds), (true, &mut trained.strain_only_seconds)]
            {
                for (k, seconds) in seconds.iter_mut().enumerate() {
                    if let Some(known) = held.seconds.get(&network_name(&mapping, strain_only, k)) {
                        *seconds = *known;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_nets::trainer::{Flow, Progress, by_name};
    use granum_nets::{Column, Data, ModelDefinition};

    fn definition() -> ModelDefinition {
        ModelDefinition {
            inputs: vec![Column::new("x", "1")],
            output: Column::new("y", "1"),
            quantities: Vec::new(),
            shares: Vec::new(),
            hidden: vec![3],
            seed: 5,
        }
    }

    fn data() -> Data {
        let x: Vec<f64> = (0..20).map(|k| k as f64 / 19.0).collect();
        let y = x.iter().map(|x| x * (1.0 - x)).collect();
        Data::new(x, 1, y).unwrap()
    }

    /// Trains up to an epoch, and returns the model and the state at its end.
    fn trained(epochs: u64, state: Option<TrainerState>) -> (Model, TrainerState) {
        let trainer = by_name("traingdx", &Default::default()).unwrap();
        let mut listen = |p: &Progress| if p.done < epochs { Flow::Continue } else { Flow::Stop };
        let (model, report) =
            Model::resume(&definition(), &data(), trainer.as_ref(), state, &mut listen).unwrap();
        (model, report.state)
    }

    #[test]
    fn a_network_under_way_is_kept_and_trusted_only_if_whole_and_of_the_same_training() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        let (_, state) = trained(40, None);
        let checkpoints = TrainingCheckpoints::new(folder, Duration::ZERO);
        assert!(checkpoints.is_due("F1-1"));
        checkpoints.under_way("F1-1", "this", &state);
        assert_eq!(checkpoints.state("F1-1", "this"), Some(state.clone()));
        assert!(checkpoints.state("F1-1", "other").is_none() && checkpoints.state("F1-2", "this").is_none());
        let (whole, _) = trained(90, None);
        let (rest, _) = trained(90, checkpoints.state("F1-1", "this"));
        assert_eq!(whole.to_json(), rest.to_json());

        let file = folder.join("F1-1.unfinished");
        let bytes = std::fs::read(&file).unwrap();
        for at in (0..bytes.len()).step_by(7) {
            let mut altered = bytes.clone();
            altered[at] ^= 1;
            std::fs::write(&file, altered).unwrap();
            assert!(checkpoints.state("F1-1", "this").is_none(), "byte {at}");
        }
        std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        assert!(checkpoints.state("F1-1", "this").is_none());

        checkpoints.trained("F1-1", &whole, 2.5);
        assert!(!file.exists() && !checkpoints.failed());
        assert_eq!(checkpoints.finished("F1-1").unwrap().to_json(), whole.to_json());
        // A second instance reads the stored times, and a damaged file of times has no other effect.
        let again = TrainingCheckpoints::new(folder, Duration::MAX);
        assert_eq!(again.held().seconds["F1-1"], 2.5);
        std::fs::write(folder.join(TIMES_FILE), "{").unwrap();
        assert!(TrainingCheckpoints::new(folder, Duration::MAX).held().seconds.is_empty());
        assert!(!again.is_due("F1-2") && again.state("F1-2", "this").is_none());
        again.under_way("F1-2", "this", &state);
        assert!(again.state("F1-2", "this").is_some());
    }

    #[test]
    fn what_cannot_be_written_is_told() {
        let base = tempfile::tempdir().unwrap();
        let checkpoints = TrainingCheckpoints::new(&base.path().join("nowhere"), Duration::ZERO);
        checkpoints.trained("F1-1", &trained(3, None).0, 1.0);
        assert!(checkpoints.failed() && checkpoints.take_failure().unwrap().to_string().contains("nowhere"));
    }

    #[test]
    fn manifests_differ_in_what_makes_other_networks() {
        let base = tempfile::tempdir().unwrap();
        let options = StudyOptions::default();
        let plan = |runs: &[PathBuf], hash: &str, options: &StudyOptions| {
            TrainingManifest::new(runs, &[], hash.to_string(), options).unwrap()
        };
        let one = plan(&["a".into()], "h", &options);
        assert!(one.runs[0].is_absolute());
        assert!(one.differences(&plan(&["b".into()], "h", &options)).is_empty());
        let other =
            StudyOptions { seed: 2, trainer: granum_nets::trainer::Traingdx::default().into(), ..options };
        assert_eq!(one.differences(&plan(&["a".into()], "g", &other)), ["runs", "trainer", "seed"]);
        assert_eq!((one.networks().len(), one.files().len()), (36, 76));
        one.write(base.path()).unwrap();
        assert_eq!(TrainingManifest::read(base.path()).unwrap(), one);
        let path = base.path().join(PLAN_FILE);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("\"seed\": 1", "\"seed\": 2")).unwrap();
        let message = TrainingManifest::read(base.path()).unwrap_err().to_string();
        assert!(message.contains("was changed or damaged"), "{message}");
        // A file of version 1 had no SHA-256.
        let old = text.split(",\n  \"sha256\"").next().unwrap().to_string() + "\n}";
        std::fs::write(&path, old.replace("\"version\": 2", "\"version\": 1")).unwrap();
        assert_eq!(TrainingManifest::read(base.path()).unwrap().dataset_hash, one.dataset_hash);
        std::fs::write(&path, old.replace("\"version\": 2", "\"version\": 0")).unwrap();
        assert!(TrainingManifest::read(base.path()).unwrap_err().to_string().contains("version 0"));
        std::fs::write(&path, &text[..50]).unwrap();
        assert!(TrainingManifest::read(base.path()).unwrap_err().to_string().contains("training.json"));
    }
}
