//! The scores of a trained study.

use serde::Serialize;

use super::sub_model_summary::SubModelSummary;
use super::trained::{Study, TrainedMapping};
use crate::baseline::{Baselines, MappingBaselines};
use crate::mapping::{Mapping, Quantity};
use crate::mapping_networks::states_of;
use crate::scatter::{Scatter, best_without_sensors};
use crate::sensor_use::{self, SensorUse, is_constant};
use crate::study_data::{Run, State, StudyData};
use granum_learn::Result;
use granum_learn::score::{Score, Scorer};

/// Scores of one mapping on one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScore {
    /// Name of the mapping.
    pub mapping: String,
    /// Score of the networks.
    pub network: Score,
    /// Score of strain-only networks of the same size.
    pub strain_only: Score,
    /// Score of ridge regression on the same sensors; null for a study without baselines.
    pub ridge: Option<Score>,
    /// Score of ridge regression on strain alone; null for a study without baselines.
    pub ridge_strain_only: Option<Score>,
    /// Score of the mean curve of the training runs; null for a study without baselines.
    pub mean_curve: Option<Score>,
    /// Number of states of the run whose strain or another input lies outside the trained range of the networks.
    pub states_outside: usize,
}

impl Study {
    /// Scores every mapping on any run.
    ///
    /// # Errors
    /// If a state contains a value that is not finite.
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

    /// The use that every mapping makes of the sensors of unseen runs.
    ///
    /// # Errors
    /// If a state contains a value that is not finite.
    pub fn sensor_use(&self, runs: &[&Run]) -> Result<Vec<SensorUse>> {
        self.mappings.iter().map(|trained| sensor_use::sensor_use(trained, runs)).collect()
    }

    /// Scores every mapping.
    ///
    /// # Errors
    /// If a state contains a value that is not finite, or a missing baseline cannot be fitted.
    pub fn evaluate(&self, dataset: &StudyData) -> Result<Vec<Evaluation>> {
        let fit = || Baselines::fit(self.mappings.iter().map(|trained| trained.surrogate.mapping()), dataset);
        let baselines = self.baselines.clone().map_or_else(fit, Ok)?;
        self.mappings.iter().map(|mapping| Evaluation::new(mapping, &baselines, dataset)).collect()
    }
}

/// Scores on the parts of a data set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// Score on the training states.
    pub training: Score,
    /// Score on the held-out states of the training runs.
    pub held_out: Score,
    /// Score on the unseen runs.
    pub unseen: Score,
}

impl Parts {
    fn new(dataset: &StudyData, score: impl Fn(&[&State]) -> Result<Score>) -> Result<Parts> {
        Ok(Parts {
            training: score(&dataset.training())?,
            held_out: score(&dataset.held_out())?,
            unseen: score(&dataset.unseen())?,
        })
    }
}

/// The evaluation of a mapping.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// The mapping.
    pub mapping: Mapping,
    /// Scores of the networks.
    pub network: Parts,
    /// Scores of strain-only networks of the same size.
    pub strain_only: Parts,
    /// Scores of the mean curve of the training runs.
    pub mean_curve: Parts,
    /// Scores of ridge regression on the same sensors.
    pub ridge: Parts,
    /// Scores of ridge regression on strain alone.
    pub ridge_strain_only: Parts,
    /// The use that the networks make of the sensors of the unseen runs.
    pub sensor_use: SensorUse,
    /// Relative scatter between all runs within the ranges of the mapping; `None` for a single run.
    pub seed_scatter: Option<f64>,
    /// Number of training runs.
    pub training_runs: usize,
    /// The summary of each network.
    pub sub_models: Vec<SubModelSummary>,
}

impl Evaluation {
    /// Evaluates a trained mapping.
    ///
    /// # Errors
    /// If a state contains a value that is not finite, or if the baselines of the mapping are missing and cannot be fitted.
    pub fn new(trained: &TrainedMapping, baselines: &Baselines, dataset: &StudyData) -> Result<Evaluation> {
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
            sensor_use: sensor_use::sensor_use(trained, &unseen)?,
            seed_scatter: scatter(dataset, mapping, mapping.output).map(|scatter| scatter.relative),
            training_runs: dataset.training_runs.len(),
            sub_models: sub_models.collect::<Result<_>>()?,
            mapping: mapping.clone(),
        })
    }

    /// Expected relative RMSE of the mean of the training runs on an unseen run.
    pub fn best_without_sensors(&self) -> Option<f64> {
        self.seed_scatter.map(|scatter| scatter * best_without_sensors(self.training_runs))
    }
}

/// Scatter of a quantity between all runs of a data set, within the ranges of a mapping.
pub(crate) fn scatter(dataset: &StudyData, mapping: &Mapping, quantity: Quantity) -> Option<Scatter> {
    let runs: Vec<&Run> = dataset.training_runs.iter().chain(&dataset.unseen_runs).collect();
    let (first, last) = (mapping.sub_models.first()?, mapping.sub_models.last()?);
    Scatter::new(quantity, &runs, [first.strain_range[0], last.strain_range[1]])
}

/// The score of predictions for the states within the ranges of a mapping.
fn score_answers(mapping: &Mapping, states: &[&State], answer: &dyn Fn(&State) -> Vec<f64>) -> Score {
    let mut scorer = Scorer::default();
    for state in states_of(mapping, states.iter().copied(), None) {
        scorer.add(state.values(mapping.output), &answer(state));
    }
    scorer.score()
}

fn describe(trained: &TrainedMapping, dataset: &StudyData, k: usize) -> Result<SubModelSummary> {
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
