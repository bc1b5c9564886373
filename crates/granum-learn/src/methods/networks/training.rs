//! The training of one network, which can be stopped and resumed.

use granum_core::observer::Observer;
use granum_nets::trainer::{self, Flow, Progress, SharedTrainer, TerminationReason};
use granum_nets::{Data, Model, ModelDefinition};

use crate::error::{LearnError, Result};
use crate::surrogate::checkpoints::NetworkCheckpoints;

/// Smallest number of training states of a sub-model.
pub const FEWEST_STATES: usize = 3;

/// One network to train.
pub struct NetworkTask {
    /// Its name, for messages.
    pub name: String,
    /// The name under which it is kept.
    pub kept_as: String,
    /// Its columns, size and seed.
    pub definition: ModelDefinition,
    /// The training rows.
    pub data: Data,
    /// The trainer.
    pub trainer: SharedTrainer,
    /// Number of epochs, if the trainer has no stopping rule of its own.
    pub epochs: Option<u64>,
}

impl NetworkTask {
    /// Trains the network, or takes it from the checkpoints, and returns it with the time of its training in seconds, which is 0
    /// if it was found finished. `None` if the observer stopped it.
    ///
    /// # Errors
    /// If the trainer returns an error.
    pub fn train(
        &self,
        observer: &mut dyn Observer,
        checkpoints: &dyn NetworkCheckpoints,
    ) -> Result<Option<Model>> {
        let failed = |reason: String| LearnError::Network { network: self.name.clone(), reason };
        let kept = self.kept_as.as_str();
        if let Some(model) = checkpoints.finished(kept).filter(|model| self.is_the_same(model)) {
            checkpoints.trained(kept, &model, 0.0);
            return Ok(Some(model));
        }
        let key = self.key();
        // A state is kept by stopping the training and continuing from its state, which changes no bit.
        let mut state = checkpoints.state(kept, &key);
        let mut seconds = 0.0;
        loop {
            let mut stopped = false;
            let mut listen = |progress: &Progress| {
                stopped = observer.progress(progress) == Flow::Stop;
                if stopped || checkpoints.keeps_state(kept) { Flow::Stop } else { Flow::Continue }
            };
            let (model, report) =
                Model::resume(&self.definition, &self.data, &*self.trainer, state.take(), &mut listen)
                    .map_err(|error| failed(error.to_string()))?;
            seconds += report.seconds;
            if report.termination == TerminationReason::Stopped {
                checkpoints.under_way(kept, &key, &report.state);
                if !stopped {
                    state = Some(report.state);
                    continue;
                }
                return Ok(None);
            }
            // The time must be positive, since a time of zero marks a network that was found finished.
            checkpoints.trained(kept, &model, seconds.max(1e-9));
            return Ok(Some(model));
        }
    }

    /// Identifies the training of the network.
    fn key(&self) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let (epochs, layers) = (self.epochs, self.definition.layers());
        format!(
            "granum {version} {} seed {} epochs {epochs:?} layers {layers:?} rows {}",
            self.trainer.name(),
            self.definition.seed,
            self.data.hash()
        )
    }

    /// True if a model is the result that the training would give.
    fn is_the_same(&self, model: &Model) -> bool {
        let provenance = model.provenance();
        let ended_alike = match self.epochs {
            Some(epochs) if provenance.termination == trainer::TerminationReason::EpochLimit => {
                provenance.epochs == epochs
            }
            Some(epochs) => provenance.epochs <= epochs,
            None => true,
        };
        ended_alike
            && provenance.termination != trainer::TerminationReason::Stopped
            && provenance.trainer == self.trainer.name()
            && provenance.seed == self.definition.seed
            && provenance.dataset_hash == self.data.hash()
            && provenance.granum_version == env!("CARGO_PKG_VERSION")
            && model.network().layers() == self.definition.layers()
            && model.inputs() == self.definition.inputs
            && *model.output() == self.definition.output
    }
}

/// The seed of a network from the seed of the study and the name of the network, so that it does not change when other networks
/// are added or removed. It is below 2^32, so that every JSON reader represents it exactly. The hash of Fowler, Noll and
/// Vo mixes the name into the seed here and is not used as a digest; another hash would give other networks.
pub fn network_seed(seed: u64, name: &str) -> u64 {
    let mut hash = name.bytes().fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    // This is the final mixing of SplitMix64 (Steele, Lea and Flood 2014).
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    hash >> 32
}
