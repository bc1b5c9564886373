//! Trains every sub-model of every mapping, each beside a network of the same size that sees strain only, and scores them.

use granum_core::parallel;
use granum_nets::trainer::{self, Control, Options, TrainerState};
use granum_nets::{Column, Data, Model, Recipe};
use serde::Serialize;

use crate::antony2006::summary::SubModelSummary;
use crate::baseline::{Baselines, MappingBaselines};
use crate::dataset::{Dataset, NamedRecord, Run, State};
use crate::error::{LearnError, Result};
use crate::mapping::{Form, Mapping, Quantity, paper_mappings};
use crate::score::{Scatter, Score, Scorer, best_without_sensors};
use crate::sensor_use::{SensorUse, is_constant};
use crate::surrogate::{Surrogate, states_of};
use crate::training_rows;

/// Fewest training states of a sub-model.
pub const FEWEST_STATES: usize = 3;
/// The trainer whose epochs are those of the tables; others end by their own rule.
pub(crate) const PAPER_TRAINER: &str = "traingdx";

/// What to train, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyOptions {
    /// The mappings.
    pub mappings: Vec<Mapping>,
    /// How the force distribution enters.
    pub form: Form,
    /// Name of the trainer.
    pub trainer: String,
    /// Factor on the epochs of the tables, for the paper's trainer `traingdx`; others end by their own rule.
    pub epoch_factor: f64,
    /// Seed of the study; every network has its own, derived from it and its name.
    pub seed: u64,
    /// Threads, one network each; 0 for as many as the machine has. The result does not depend on it.
    pub threads: usize,
}

impl Default for StudyOptions {
    fn default() -> Self {
        StudyOptions {
            mappings: paper_mappings(),
            form: Form::Point,
            trainer: "levenberg-marquardt".to_owned(),
            epoch_factor: 1.0,
            seed: 1,
            threads: 0,
        }
    }
}

/// Where a study stands, told from the thread that trains.
#[derive(Clone, Copy, Debug)]
pub struct StudyProgress<'a> {
    /// Name of the network: `F1-2`, or `F1-strain-only-2` for the one that sees strain only.
    pub network: &'a str,
    /// Epochs done.
    pub epoch: u64,
    /// Most epochs that will be done.
    pub epochs: u64,
    /// Mean squared error, in scaled units.
    pub error: f64,
}

/// Hears of a study, keeps its networks as they come, and may end it. Every method has a default that does nothing.
pub trait StudyObserver: Sync {
    /// Called after every epoch of every network.
    fn progress(&self, _progress: &StudyProgress) {}
    /// Called when a network is trained, with the seconds that took, or was found finished (0).
    fn trained(&self, _network: &str, _model: &Model, _seconds: f64) {}
    /// Called after every epoch with what is needed to go on from here, for a training that is told by `key`. `last` is
    /// true if the training ends here because [`StudyObserver::stop`] asks for it.
    fn under_way(&self, _network: &str, _key: &str, _last: bool, _state: &dyn Fn() -> TrainerState) {}
    /// The state of an unfinished training that is told by `key`, to go on from.
    fn state(&self, _network: &str, _key: &str) -> Option<TrainerState> {
        None
    }
    /// A network of an earlier, unfinished study. It is used if it was trained on the same rows with the same size,
    /// seed, trainer and epochs, and else trained again.
    fn finished(&self, _network: &str) -> Option<Model> {
        None
    }
    /// True to end the study.
    fn stop(&self) -> bool {
        false
    }
}

/// An observer that looks away.
pub struct Silent;

impl StudyObserver for Silent {}

/// A trained study.
#[derive(Clone, Debug)]
pub struct Study {
    /// How the force distribution enters.
    pub form: Form,
    /// Trainer.
    pub trainer: String,
    /// Seed of the study.
    pub seed: u64,
    /// Hash of the data set, see [`Dataset::hash`].
    pub dataset_hash: String,
    /// Centres of the bins of f.
    pub forces: Vec<f64>,
    /// Width of a bin.
    pub bin_width: f64,
    /// The mappings, each with its strain-only networks.
    pub mappings: Vec<TrainedMapping>,
    /// What stands beside the networks; `None` of a study that was saved before they were kept.
    pub baselines: Option<Baselines>,
}

/// Scores of one mapping on one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScore {
    /// Name of the mapping.
    pub mapping: String,
    /// Its networks.
    pub network: Score,
    /// Networks of the same sizes that see strain only.
    pub strain_only: Score,
    /// Ridge regression on the same sensors, the same on strain alone, and the mean curve of the training runs; null of a
    /// study that does not hold them.
    pub ridge: Option<Score>,
    /// See `ridge`.
    pub ridge_strain_only: Option<Score>,
    /// See `ridge`.
    pub mean_curve: Option<Score>,
    /// States of the run that lie, in strain or in an input, outside what the networks were trained on.
    pub states_outside: usize,
}

/// A mapping, trained.
#[derive(Clone, Debug)]
pub struct TrainedMapping {
    /// The networks.
    pub surrogate: Surrogate,
    /// Networks of the same sizes that see strain only.
    pub strain_only: Surrogate,
    /// Seconds of training of each network of `surrogate`; 0 for one that was found finished.
    pub seconds: Vec<f64>,
    /// The same for `strain_only`.
    pub strain_only_seconds: Vec<f64>,
}

/// One network to train.
pub(crate) struct Job<'a> {
    pub(crate) name: String,
    pub(crate) mapping: &'a Mapping,
    pub(crate) sub_model: usize,
    pub(crate) seed: u64,
}

/// Name of the network of a sub-model.
pub fn network_name(mapping: &Mapping, strain_only: bool, sub_model: usize) -> String {
    let mark = if strain_only { "-strain-only" } else { "" };
    format!("{}{mark}-{}", mapping.name, sub_model + 1)
}

impl Study {
    /// Trains all networks, independent ones side by side.
    ///
    /// # Errors
    /// If a sub-model has too few training states, the trainer is unknown or refuses, or the observer ends it.
    pub fn train(dataset: &Dataset, options: &StudyOptions, observer: &dyn StudyObserver) -> Result<Study> {
        let alone: Vec<Mapping> = options.mappings.iter().map(Mapping::strain_only).collect();
        let mut jobs = Vec::new();
        for (mappings, strain_only) in [(&options.mappings, false), (&alone, true)] {
            for mapping in mappings {
                for sub_model in 0..mapping.sub_models.len() {
                    let name = network_name(mapping, strain_only, sub_model);
                    let seed = network_seed(options.seed, &name);
                    jobs.push(Job { name, mapping, sub_model, seed });
                }
            }
        }
        let trained = train_all(dataset, &jobs, options, observer)?;
        let mut trained = trained.into_iter();
        let mut collect = |mappings: &[Mapping]| -> Result<Vec<(Surrogate, Vec<f64>)>> {
            mappings.iter().map(|mapping| gather(mapping, options.form, dataset, &mut trained)).collect()
        };
        let surrogates = collect(&options.mappings)?;
        let strain_only = collect(&alone)?;
        let mappings = surrogates.into_iter().zip(strain_only).map(|(own, alone)| TrainedMapping {
            surrogate: own.0,
            seconds: own.1,
            strain_only: alone.0,
            strain_only_seconds: alone.1,
        });
        Ok(Study {
            form: options.form,
            trainer: options.trainer.clone(),
            seed: options.seed,
            dataset_hash: dataset.hash()?,
            forces: dataset.forces.clone(),
            bin_width: dataset.bin_width,
            mappings: mappings.collect(),
            baselines: Some(Baselines::fit(&options.mappings, dataset)?),
        })
    }

    /// The mapping of that name.
    ///
    /// # Errors
    /// [`LearnError::Unknown`].
    pub fn mapping(&self, name: &str) -> Result<&TrainedMapping> {
        let names = || self.mappings.iter().map(|m| m.surrogate.mapping().name.as_str()).collect::<Vec<_>>();
        self.mappings.iter().find(|m| m.surrogate.mapping().name == name).ok_or_else(|| LearnError::Unknown {
            kind: "mapping",
            name: name.to_owned(),
            known: names().join(", "),
        })
    }

    /// Draws from any record the states that the networks can answer.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn read(&self, record: &NamedRecord) -> Result<Run> {
        Run::new(record, &self.forces, self.bin_width)
    }

    /// Scores every mapping on any run.
    ///
    /// # Errors
    /// If a state holds a value that is not finite.
    pub fn score_run(&self, run: &Run) -> Result<Vec<RunScore>> {
        let score = |trained: &TrainedMapping| -> Result<RunScore> {
            let mapping = trained.surrogate.mapping();
            let answers = trained.surrogate.answer(&run.states)?;
            let states: Vec<&State> = run.states.iter().collect();
            let baselines = self.baselines.as_ref();
            let both = baselines.and_then(|baselines| baselines.mappings.get(&mapping.name));
            let by = |answer: &dyn Fn(&State) -> Vec<f64>| score_answers(mapping, &states, answer);
            Ok(RunScore {
                mapping: mapping.name.clone(),
                network: trained.surrogate.evaluate(&run.states, None)?,
                strain_only: trained.strain_only.evaluate(&run.states, None)?,
                ridge: both.map(|both| by(&|state| both.ridge.answer(state))),
                ridge_strain_only: both.map(|both| by(&|state| both.strain_only.answer(state))),
                mean_curve: baselines
                    .map(|baselines| by(&|state| baselines.mean_curve.answer(mapping.output, state.strain))),
                states_outside: answers.iter().filter(|answer| answer.outside).count(),
            })
        };
        self.mappings.iter().map(score).collect()
    }

    /// Seconds of training of all networks that answer (strain-only networks left out).
    pub fn training_seconds(&self) -> f64 {
        self.mappings.iter().flat_map(|mapping| &mapping.seconds).sum()
    }

    /// What every mapping makes of the sensors of unseen runs.
    ///
    /// # Errors
    /// If a state holds a value that is not finite.
    pub fn sensor_use(&self, runs: &[&Run]) -> Result<Vec<SensorUse>> {
        self.mappings.iter().map(|trained| SensorUse::new(trained, runs)).collect()
    }

    /// Scores every mapping.
    ///
    /// # Errors
    /// If a state holds a value that is not finite, or a baseline must be fitted and cannot be.
    pub fn evaluate(&self, dataset: &Dataset) -> Result<Vec<Evaluation>> {
        let fit = || Baselines::fit(self.mappings.iter().map(|trained| trained.surrogate.mapping()), dataset);
        let baselines = self.baselines.clone().map_or_else(fit, Ok)?;
        self.mappings.iter().map(|mapping| Evaluation::new(mapping, &baselines, dataset)).collect()
    }
}

/// Trains jobs over threads.
pub(crate) fn train_all(
    dataset: &Dataset,
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

/// Trains one network; `None` if the observer ended it.
fn train_one(
    dataset: &Dataset,
    states: &[&State],
    job: &Job,
    options: &StudyOptions,
    observer: &dyn StudyObserver,
) -> Result<Option<(Model, f64)>> {
    let failed = |reason: String| LearnError::Network { network: job.name.clone(), reason };
    let sub_model = &job.mapping.sub_models[job.sub_model];
    let rule = training_rows::rule_of(&options.trainer);
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
    let epochs = (options.trainer == PAPER_TRAINER)
        .then(|| (sub_model.epochs as f64 * options.epoch_factor).round().max(1.0) as u64);
    let first_ratio = training_rows::first_ratio(job.mapping);
    let settings = Options { epochs, first_ratio, ..Options::default() };
    let trainer = trainer::by_name(&options.trainer, &settings).map_err(|e| failed(e.to_string()))?;
    let recipe = Recipe {
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
    if let Some(model) = found.filter(|model| is_the_same(model, &recipe, &data, &options.trainer, epochs)) {
        return Ok(Some((model, 0.0)));
    }
    let layers = recipe.layers();
    let version = env!("CARGO_PKG_VERSION");
    let key = format!(
        "granum {version} {} seed {} epochs {epochs:?} layers {layers:?} rows {}",
        options.trainer,
        job.seed,
        data.hash()
    );
    let mut stopped = false;
    let mut listen = |progress: &trainer::Progress| {
        let (epoch, epochs, error) = (progress.epoch, progress.epochs, progress.error);
        observer.progress(&StudyProgress { network: &job.name, epoch, epochs, error });
        stopped = observer.stop();
        observer.under_way(&job.name, &key, stopped, &|| progress.state());
        if stopped { Control::Stop } else { Control::Continue }
    };
    let state = observer.state(&job.name, &key);
    let (model, report) = Model::resume(&recipe, &data, trainer.as_ref(), state, &mut listen)
        .map_err(|error| failed(error.to_string()))?;
    // A network that took no time at all is told apart from one that was found.
    Ok((!stopped).then_some((model, report.seconds.max(1e-9))))
}

/// True if a model is what training by the recipe would give.
fn is_the_same(model: &Model, recipe: &Recipe, data: &Data, trainer: &str, epochs: Option<u64>) -> bool {
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
        && provenance.seed == recipe.seed
        && provenance.dataset_hash == data.hash()
        && provenance.granum_version == env!("CARGO_PKG_VERSION")
        && model.network().layers() == recipe.layers()
        && model.inputs() == recipe.inputs
        && *model.output() == recipe.output
}

/// The next networks of an iterator as the surrogate of a mapping.
fn gather(
    mapping: &Mapping,
    form: Form,
    dataset: &Dataset,
    trained: &mut impl Iterator<Item = (Model, f64)>,
) -> Result<(Surrogate, Vec<f64>)> {
    let (models, seconds) = trained.take(mapping.sub_models.len()).unzip();
    Ok((Surrogate::new(mapping.clone(), form, dataset.forces.clone(), models)?, seconds))
}

/// The seed of a network, from that of the study and its name: stable when mappings are added or left out. Below 2^32,
/// so that every reader of JSON keeps it exactly.
pub(crate) fn network_seed(seed: u64, name: &str) -> u64 {
    let mut hash = name.bytes().fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    // Final mixing of SplitMix64 (Steele, Lea and Flood 2014).
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    hash >> 32
}

/// Scores on the parts of a data set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// On the states that trained.
    pub training: Score,
    /// On the held-out states of the training runs.
    pub held_out: Score,
    /// On the unseen runs.
    pub unseen: Score,
}

impl Parts {
    fn new(dataset: &Dataset, score: impl Fn(&[&State]) -> Result<Score>) -> Result<Parts> {
        Ok(Parts {
            training: score(&dataset.training())?,
            held_out: score(&dataset.held_out())?,
            unseen: score(&dataset.unseen())?,
        })
    }
}

/// A mapping, judged.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// The mapping.
    pub mapping: Mapping,
    /// Its networks.
    pub network: Parts,
    /// Networks of the same sizes that see strain only.
    pub strain_only: Parts,
    /// The mean curve of the training runs, with no network.
    pub mean_curve: Parts,
    /// Ridge regression on the same sensors.
    pub ridge: Parts,
    /// Ridge regression on strain alone.
    pub ridge_strain_only: Parts,
    /// What the networks make of the sensors of the unseen runs.
    pub sensor_use: SensorUse,
    /// Scatter between all runs, relative, within the ranges of the mapping; `None` of a single run.
    pub seed_scatter: Option<f64>,
    /// Number of training runs.
    pub training_runs: usize,
    /// Each network.
    pub sub_models: Vec<SubModelSummary>,
}

impl Evaluation {
    /// Judges a trained mapping.
    ///
    /// # Errors
    /// If a state holds a value that is not finite, or the baselines lack the mapping and cannot be fitted.
    pub fn new(trained: &TrainedMapping, baselines: &Baselines, dataset: &Dataset) -> Result<Evaluation> {
        let mapping = trained.surrogate.mapping();
        let kept = baselines.mappings.get(&mapping.name).cloned();
        let both = kept.map_or_else(|| MappingBaselines::fit(mapping, dataset), Ok)?;
        let curve = &baselines.mean_curve;
        let sub_models = (0..mapping.sub_models.len()).map(|k| describe(trained, dataset, k));
        let by = |answer: &dyn Fn(&State) -> Vec<f64>| {
            Parts::new(dataset, |states| Ok(score_answers(mapping, states, answer)))
        };
        let unseen: Vec<&Run> = dataset.unseen_runs.iter().collect();
        Ok(Evaluation {
            network: Parts::new(dataset, |states| trained.surrogate.evaluate(states.iter().copied(), None))?,
            strain_only: Parts::new(dataset, |states| {
                trained.strain_only.evaluate(states.iter().copied(), None)
            })?,
            mean_curve: by(&|state| curve.answer(mapping.output, state.strain))?,
            ridge: by(&|state| both.ridge.answer(state))?,
            ridge_strain_only: by(&|state| both.strain_only.answer(state))?,
            sensor_use: SensorUse::new(trained, &unseen)?,
            seed_scatter: scatter(dataset, mapping, mapping.output).map(|scatter| scatter.relative),
            training_runs: dataset.training_runs.len(),
            sub_models: sub_models.collect::<Result<_>>()?,
            mapping: mapping.clone(),
        })
    }

    /// Relative RMSE that the mean of the training runs would have on an unseen run if it were free of error.
    pub fn best_without_sensors(&self) -> Option<f64> {
        self.seed_scatter.map(|scatter| scatter * best_without_sensors(self.training_runs))
    }
}

/// Scatter of a quantity between all runs of a data set, within the ranges of a mapping.
pub(crate) fn scatter(dataset: &Dataset, mapping: &Mapping, quantity: Quantity) -> Option<Scatter> {
    let runs: Vec<&Run> = dataset.training_runs.iter().chain(&dataset.unseen_runs).collect();
    let (first, last) = (mapping.sub_models.first()?, mapping.sub_models.last()?);
    Scatter::new(quantity, &runs, [first.strain_range[0], last.strain_range[1]])
}

/// Scores answers to the states within the ranges of a mapping.
fn score_answers(mapping: &Mapping, states: &[&State], answer: &dyn Fn(&State) -> Vec<f64>) -> Score {
    let mut scorer = Scorer::default();
    for state in states_of(mapping, states.iter().copied(), None) {
        scorer.add(state.values(mapping.output), &answer(state));
    }
    scorer.score()
}

fn describe(trained: &TrainedMapping, dataset: &Dataset, k: usize) -> Result<SubModelSummary> {
    let sub_model = &trained.surrogate.mapping().sub_models[k];
    let model = &trained.surrogate.networks()[k];
    let provenance = model.provenance();
    Ok(SubModelSummary {
        strain_range: sub_model.strain_range,
        hidden: sub_model.hidden.clone(),
        epochs: provenance.epochs,
        trainer: provenance.trainer.clone(),
        rows: provenance.rows,
        termination: provenance.termination.to_string(),
        seconds: trained.seconds[k],
        effective_parameters: model.training_fit().evidence.map(|evidence| evidence.gamma),
        constant: is_constant(&trained.surrogate, &dataset.training(), k)?,
        held_out: trained.surrogate.evaluate(dataset.held_out(), Some(k))?,
        unseen: trained.surrogate.evaluate(dataset.unseen(), Some(k))?,
    })
}
