//! Networks and the states of unfinished networks in a folder, so that a training can be resumed from its folder alone.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use granum_core::clock::Instant;

use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::sealed::{unseal, write_sealed};
use granum_nets::Model;
use granum_nets::trainer::TrainerState;
use serde::{Deserialize, Serialize};

use crate::error::{LearnError, Result};
use crate::surrogate::checkpoints::NetworkCheckpoints;

/// File with the training times of the networks. They are separate because all other files are reproducible byte by byte.
pub const TIMES_FILE: &str = "seconds.json";

/// File of a network.
fn network_file(network: &str) -> String {
    format!("{network}.json")
}

/// File with the state of an unfinished network.
fn state_file(network: &str) -> String {
    format!("{network}.unfinished")
}

/// Keeps networks in a folder: each network when it is trained, and the state of unfinished networks at intervals.
pub struct KeptNetworks {
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

impl KeptNetworks {
    /// Keeps networks in an existing folder, and the states of unfinished networks at the given interval.
    pub fn new(folder: &Path, every: Duration) -> KeptNetworks {
        // The times do not affect any result, so that a damaged file is simply replaced.
        let seconds = KeptNetworks::times(folder);
        KeptNetworks {
            folder: folder.to_path_buf(),
            every,
            held: Mutex::new(Held { seconds, ..Held::default() }),
            failed: AtomicBool::new(false),
        }
    }

    /// The training times of the networks in a folder by name, s; empty if they are unknown.
    pub fn times(folder: &Path) -> BTreeMap<String, f64> {
        let path = folder.join(TIMES_FILE);
        let text =
            granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT).unwrap_or_default();
        let text = unseal(&path, &text).map(|unsealed| unsealed.text).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Every file that may be written to the folder for networks of these names, also one that a killed process left
    /// half-written.
    pub fn files(names: &[String]) -> Vec<String> {
        let each = |name: &String| {
            let network = network_file(name);
            [format!("{network}.part"), network, state_file(name)]
        };
        names.iter().flat_map(each).chain([TIMES_FILE.to_string()]).collect()
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes an error of a file that could not be written.
    pub fn note(&self, result: Result<()>) {
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

    fn write_trained(&self, network: &str, model: &Model, seconds: f64) -> Result<()> {
        let failed = |e: granum_nets::ModelError| LearnError::Network {
            network: network.into(),
            reason: e.to_string(),
        };
        model.save(&self.folder.join(network_file(network))).map_err(failed)?;
        let mut held = self.held();
        held.seconds.insert(network.to_string(), seconds);
        Ok(write_sealed(&self.folder.join(TIMES_FILE), &held.seconds)?)
    }

    fn write_state(&self, network: &str, under_way: UnderWay) -> Result<()> {
        let path = self.folder.join(state_file(network));
        let text = serde_json::to_string(&under_way)
            .map_err(|error| LearnError::Network { network: network.into(), reason: error.to_string() })?;
        let sum = crc32fast::hash(text.as_bytes());
        write_atomically(&path, |file| write!(file, "{sum:08x}\n{text}\n"))?;
        Ok(())
    }
}

impl NetworkCheckpoints for KeptNetworks {
    fn finished(&self, network: &str) -> Option<Model> {
        Model::load(&self.folder.join(network_file(network))).ok()
    }

    fn trained(&self, network: &str, model: &Model, seconds: f64) {
        if seconds > 0.0 {
            self.note(self.write_trained(network, model, seconds));
        }
        // A state may be left even next to a finished network if the process was killed between the two operations.
        let state = self.folder.join(state_file(network));
        if state.exists() {
            self.note(std::fs::remove_file(&state).map_err(|e| Error::file("remove", &state)(e).into()));
        }
    }

    fn keeps_state(&self, network: &str) -> bool {
        let mut held = self.held();
        match held.kept.get(network) {
            Some(last) => last.elapsed() > self.every,
            None => {
                held.kept.insert(network.to_string(), Instant::now());
                self.every.is_zero()
            }
        }
    }

    fn under_way(&self, network: &str, key: &str, state: &TrainerState) {
        self.held().kept.insert(network.to_string(), Instant::now());
        self.note(self.write_state(network, UnderWay { key: key.to_string(), state: state.clone() }));
    }

    /// `None` unless the state is complete and belongs to the same training; the network is then trained from the start.
    fn state(&self, network: &str, key: &str) -> Option<TrainerState> {
        let path = self.folder.join(state_file(network));
        let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT).ok()?;
        let (sum, text) = text.split_once('\n')?;
        let text = text.strip_suffix('\n')?;
        if u32::from_str_radix(sum, 16).ok()? != crc32fast::hash(text.as_bytes()) {
            return None;
        }
        let under_way: UnderWay = serde_json::from_str(text).ok()?;
        (under_way.key == key).then_some(under_way.state)
    }

    fn seconds(&self, network: &str) -> Option<f64> {
        self.held().seconds.get(network).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_nets::trainer::{Flow, Progress, by_name};
    use granum_nets::{Data, ModelColumn, ModelDefinition};

    fn definition() -> ModelDefinition {
        ModelDefinition {
            seed: 5,
            ..ModelDefinition::new(vec![ModelColumn::new("x", "1")], ModelColumn::new("y", "1"), vec![3])
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
        let checkpoints = KeptNetworks::new(folder, Duration::ZERO);
        assert!(checkpoints.keeps_state("y-1"));
        checkpoints.under_way("y-1", "this", &state);
        assert_eq!(checkpoints.state("y-1", "this"), Some(state.clone()));
        assert!(checkpoints.state("y-1", "other").is_none() && checkpoints.state("y-2", "this").is_none());
        let (whole, _) = trained(90, None);
        let (rest, _) = trained(90, checkpoints.state("y-1", "this"));
        assert_eq!(whole.to_json(), rest.to_json());

        let file = folder.join("y-1.unfinished");
        let bytes = std::fs::read(&file).unwrap();
        for at in (0..bytes.len()).step_by(7) {
            let mut altered = bytes.clone();
            altered[at] ^= 1;
            std::fs::write(&file, altered).unwrap();
            assert!(checkpoints.state("y-1", "this").is_none(), "byte {at}");
        }
        std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        assert!(checkpoints.state("y-1", "this").is_none());

        checkpoints.trained("y-1", &whole, 2.5);
        assert!(!file.exists() && !checkpoints.failed());
        assert_eq!(checkpoints.finished("y-1").unwrap().to_json(), whole.to_json());
        // A second instance reads the stored times, and a damaged file of times has no other effect.
        let again = KeptNetworks::new(folder, Duration::MAX);
        assert_eq!(again.seconds("y-1"), Some(2.5));
        std::fs::write(folder.join(TIMES_FILE), "{").unwrap();
        assert_eq!(KeptNetworks::new(folder, Duration::MAX).seconds("y-1"), None);
        assert!(!again.keeps_state("y-2") && again.state("y-2", "this").is_none());
        again.under_way("y-2", "this", &state);
        assert!(again.state("y-2", "this").is_some());
    }

    #[test]
    fn what_cannot_be_written_is_told() {
        let base = tempfile::tempdir().unwrap();
        let checkpoints = KeptNetworks::new(&base.path().join("nowhere"), Duration::ZERO);
        checkpoints.trained("y-1", &trained(3, None).0, 1.0);
        assert!(checkpoints.failed() && checkpoints.take_failure().unwrap().to_string().contains("nowhere"));
    }
}
