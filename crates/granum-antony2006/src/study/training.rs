//! The training of the networks of a study, in parallel.

use granum_core::parallel;
use granum_nets::trainer::{self, Flow, Options, Progress, TerminationReason};
use granum_nets::{Column, Data, Model, ModelDefinition};

use super::observer::{StudyObserver, StudyProgress};
use super::options::{FEWEST_STATES, PAPER_TRAINER, StudyOptions};
use crate::mapping::Mapping;
use crate::mapping_networks::states_of;
use crate::study_data::{State, StudyData};
use crate::training_rows;
use granum_learn::{LearnError, Result};

/// One network to train.
pub(crate) struct Job<'a> {
    pub(crate) name: String,
    pub(crate) mapping: &'a Mapping,
    pub(crate) sub_model: usize,
    pub(crate) seed: u64,
}

/// Trains the networks of all jobs with several threads.
pub(crate) fn train_all(
    dataset: &StudyData,
    jobs: &[Job],
    options: &StudyOptions,
    observer: &dyn StudyObserver,
) -> Result<Vec<(Model, f64)>> {
    let states = dataset.training();
    let done = std::sync::atomic::AtomicUsize::new(0);
    parallel::map(jobs.len(), options.threads, |k| {
        let stopped = || LearnError::Stopped {
            done: done.load(std::sync::atomic::Ordering::Relaxed),
            total: jobs.len(),
        };
        if observer.stop() {
            return Err(stopped());
        }
        let (model, seconds) =
            train_one(dataset, &states, &jobs[k], options, observer)?.ok_or_else(stopped)?;
        done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        observer.trained(&jobs[k].name, &model, seconds);
        Ok((model, seconds))
    })
}

/// Trains one network; `None` if the observer stopped it.
fn train_one(
    dataset: &StudyData,
    states: &[&State],
    job: &Job,
    options: &StudyOptions,
    observer: &dyn StudyObserver,
) -> Result<Option<(Model, f64)>> {
    let failed = |reason: String| LearnError::Network { network: job.name.clone(), reason };
    let sub_model = &job.mapping.sub_models[job.sub_model];
    let rule = training_rows::rule_of(options.trainer.name());
    let own = states_of(job.mapping, states.iter().copied(), Some(job.sub_model));
    if own.len() < FEWEST_STATES {
        return Err(LearnError::TooFewStates {
            mapping: job.mapping.name.clone(),
            sub_model: job.sub_model + 1,
            low: sub_model.strain_range[0],
            high: sub_model.strain_range[1],
            found: own.len(),
            needed: FEWEST_STATES,
        });
    }
    let data = training_rows::data(dataset, job.mapping, job.sub_model, options.form, rule)
        .map_err(|e| failed(e.to_string()))?;
    let epochs = (options.trainer.name() == PAPER_TRAINER)
        .then(|| (sub_model.epochs as f64 * options.epoch_factor).round().max(1.0) as u64);
    let first_ratio = training_rows::first_ratio(job.mapping);
    let settings = Options { epochs, first_ratio, ..Options::default() };
    let trainer = options.trainer.adapted(&settings).unwrap_or_else(|| options.trainer.clone());
    let definition = ModelDefinition {
        inputs: job
            .mapping
            .network_inputs(options.form, &dataset.forces)
            .iter()
            .map(|name| Column::new(name, "1"))
            .collect(),
        output: Column::new(job.mapping.network_output(), "1"),
        quantities: training_rows::quantities(job.mapping, options.form, dataset.forces.len(), rule),
        shares: training_rows::shares(dataset, job.mapping, options.form, rule)?,
        hidden: sub_model.hidden.clone(),
        seed: job.seed,
    };
    let found = observer.finished(&job.name);
    if let Some(model) = found.filter(|model| is_the_same(model, &definition, &data, trainer.name(), epochs))
    {
        return Ok(Some((model, 0.0)));
    }
    let layers = definition.layers();
    let version = env!("CARGO_PKG_VERSION");
    let key = format!(
        "granum {version} {} seed {} epochs {epochs:?} layers {layers:?} rows {}",
        trainer.name(),
        job.seed,
        data.hash()
    );
    // A state is kept by stopping the training and continuing from its state, which changes no bit.
    let mut state = observer.state(&job.name, &key);
    let mut seconds = 0.0;
    loop {
        let mut stopped = false;
        let mut listen = |progress: &Progress| {
            let (epoch, epochs) = (progress.done, progress.of.unwrap_or(progress.done));
            let error = progress.value("error").unwrap_or(f64::NAN);
            observer.progress(&StudyProgress { network: &job.name, epoch, epochs, error });
            stopped = observer.stop();
            if stopped || observer.keeps_state(&job.name) { Flow::Stop } else { Flow::Continue }
        };
        let (model, report) = Model::resume(&definition, &data, trainer.as_ref(), state.take(), &mut listen)
            .map_err(|error| failed(error.to_string()))?;
        seconds += report.seconds;
        if report.termination == TerminationReason::Stopped {
            observer.under_way(&job.name, &key, &report.state);
            if !stopped {
                state = Some(report.state);
                continue;
            }
        }
        // The time must be positive, since a time of zero marks a network that was found finished.
        return Ok((!stopped).then_some((model, seconds.max(1e-9))));
    }
}

/// True if a model is the result that training with the definition would give.
fn is_the_same(
    model: &Model,
    definition: &ModelDefinition,
    data: &Data,
    trainer: &str,
    epochs: Option<u64>,
) -> bool {
    let provenance = model.provenance();
    let ended_alike = match epochs {
        Some(epochs) if provenance.termination == trainer::TerminationReason::EpochLimit => {
            provenance.epochs == epochs
        }
        Some(epochs) => provenance.epochs <= epochs,
        None => true,
    };
    ended_alike
        && provenance.termination != trainer::TerminationReason::Stopped
        && provenance.trainer == trainer
        && provenance.seed == definition.seed
        && provenance.dataset_hash == data.hash()
        && provenance.granum_version == env!("CARGO_PKG_VERSION")
        && model.network().layers() == definition.layers()
        && model.inputs() == definition.inputs
        && *model.output() == definition.output
}

/// Name of the network of a sub-model.
pub fn network_name(mapping: &Mapping, strain_only: bool, sub_model: usize) -> String {
    let mark = if strain_only { "-strain-only" } else { "" };
    format!("{}{mark}-{}", mapping.name, sub_model + 1)
}

/// The seed of a network from the seed of the study and the name of the network, so that it does not change when mappings
/// are added or removed. It is below 2^32, so that every JSON reader represents it exactly. The hash of Fowler, Noll and
/// Vo mixes the name into the seed here and is not used as a digest; another hash would give other networks.
pub(crate) fn network_seed(seed: u64, name: &str) -> u64 {
    let mut hash = name.bytes().fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    // This is the final mixing of SplitMix64 (Steele, Lea and Flood 2014).
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    hash >> 32
}
