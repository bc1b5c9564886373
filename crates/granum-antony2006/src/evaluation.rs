//! The scores of the study in the terms of the paper.

use granum_learn::dataset::{Dataset, RunStates};
use granum_learn::input_use::InputUse;
use granum_learn::networks::{NetworkScores, SubModelNetworks, networks_of};
use granum_learn::scatter::{Scatter, best_without_inputs};
use granum_learn::score::Score;
use granum_learn::study::{FitScores, Member, MemberRole, MemberScores, Study, StudyFit};
use granum_learn::{LearnError, Result};
use serde::Serialize;

use crate::data::{PaperData, check_run};
use crate::mapping::{Mapping, PaperQuantity};
use crate::method::NAME;

/// The networks of a mapping in a study.
///
/// # Errors
/// [`LearnError::Unknown`] if the study has no such mapping.
pub fn networks<'a>(study: &'a Study, mapping: &str) -> Result<&'a SubModelNetworks> {
    trained(study, mapping, MemberRole::Asked)
}

/// The strain-only networks of a mapping in a study.
///
/// # Errors
/// [`LearnError::Unknown`] if the study has no such mapping.
pub fn strain_only<'a>(study: &'a Study, mapping: &str) -> Result<&'a SubModelNetworks> {
    trained(study, mapping, MemberRole::CoordinateOnly)
}

fn trained<'a>(study: &'a Study, mapping: &str, role: MemberRole) -> Result<&'a SubModelNetworks> {
    let fit = study.fits.iter().find(|fit| fit.name == mapping);
    let member = fit.and_then(|fit| member(fit, NAME, role));
    member.and_then(|member| networks_of(member.surrogate.as_ref())).ok_or_else(|| LearnError::Unknown {
        kind: "mapping",
        name: mapping.to_owned(),
        known: study.fits.iter().map(|fit| fit.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}

fn member<'a>(fit: &'a StudyFit, method: &str, role: MemberRole) -> Option<&'a Member> {
    fit.members.iter().find(|member| member.method == method && member.role == role)
}

/// Total training time of all networks except the strain-only ones, s.
pub fn training_seconds(study: &Study) -> f64 {
    study
        .members()
        .filter(|member| member.role == MemberRole::Asked)
        .map(|member| study.seconds_of(member))
        .sum()
}

/// Scores of one mapping on one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScore {
    /// Name of the mapping.
    pub mapping: String,
    /// Score of the networks.
    pub network: Score,
    /// Score of strain-only networks of the same size.
    pub strain_only: Score,
    /// Score of ridge regression on the same sensors; null if it could not be fitted.
    pub ridge: Option<Score>,
    /// Score of ridge regression on strain alone; null if it could not be fitted.
    pub ridge_strain_only: Option<Score>,
    /// Score of the mean curve of the training runs; null if there is none.
    pub mean_curve: Option<Score>,
    /// Number of states of the run whose strain or another input lies outside the trained range of the networks.
    pub states_outside: usize,
}

/// The states of a run that are scored: all but state 0.
///
/// # Errors
/// If the run is no test of the paper with the bins of the networks, or has no other state.
pub fn scored_run(study: &Study, run: &RunStates) -> Result<RunStates> {
    for networks in study.members().filter_map(|member| networks_of(member.surrogate.as_ref())) {
        let quantities = networks.mapping().inputs.iter().chain([&networks.mapping().output]);
        for bins in quantities.filter_map(|quantity| quantity.bins.as_ref()) {
            check_run(run, bins)?;
        }
    }
    let whole = Dataset::new(vec![run.clone()])?;
    let states = whole.select(|run, row| run.table().values("state").is_none_or(|states| states[row] > 0.0));
    let none = || LearnError::Dataset(format!("run {} has no state to score", run.name()));
    states.runs().first().cloned().ok_or_else(none)
}

/// Scores every mapping on the states of a run, see [`scored_run`].
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn score_run(study: &Study, run: &RunStates) -> Result<Vec<RunScore>> {
    let part = Dataset::new(vec![run.clone()])?;
    let score = |fit: &StudyFit| -> Result<RunScore> {
        let of = |method: &str, role: MemberRole| {
            member(fit, method, role).map(|member| study.score_part(member, &part)).transpose()
        };
        let baseline =
            |method: &str, role: MemberRole| Ok::<_, LearnError>(of(method, role)?.map(|part| part.score));
        let network = of(NAME, MemberRole::Asked)?.unwrap_or_default();
        Ok(RunScore {
            mapping: fit.name.clone(),
            network: network.score,
            strain_only: of(NAME, MemberRole::CoordinateOnly)?.unwrap_or_default().score,
            ridge: baseline("ridge", MemberRole::Baseline)?,
            ridge_strain_only: baseline("ridge", MemberRole::CoordinateOnly)?,
            mean_curve: baseline("mean-curve", MemberRole::Baseline)?,
            states_outside: network.outside,
        })
    };
    study.fits.iter().map(score).collect()
}

/// The use that the networks of every mapping make of the sensors of unseen runs, by the name of the mapping.
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn sensor_use(study: &Study, unseen: &Dataset) -> Result<Vec<(String, InputUse)>> {
    let mut all = Vec::new();
    for fit in &study.fits {
        if let Some(member) = member(fit, NAME, MemberRole::Asked) {
            let used = study.member_use(fit, member, unseen)?;
            all.push((fit.name.clone(), used.unwrap_or_default()));
        }
    }
    Ok(all)
}

/// Scores on the parts of a data set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScoreParts {
    /// Score on the training states.
    pub training: Score,
    /// Score on the held-out states of the training runs.
    pub held_out: Score,
    /// Score on the unseen runs.
    pub unseen: Score,
}

impl ScoreParts {
    fn new(scores: &FitScores, method: &str, role: MemberRole) -> ScoreParts {
        let own = |member: &&MemberScores| member.method == method && member.role == role;
        let parts = |member: &MemberScores| ScoreParts {
            training: member.training.score,
            held_out: member.held_out.score,
            unseen: member.unseen.score,
        };
        scores.members.iter().find(own).map(parts).unwrap_or_default()
    }
}

/// The evaluation of a mapping.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// The mapping.
    pub mapping: Mapping,
    /// Scores of the networks.
    pub network: ScoreParts,
    /// Scores of strain-only networks of the same size.
    pub strain_only: ScoreParts,
    /// Scores of the mean curve of the training runs.
    pub mean_curve: ScoreParts,
    /// Scores of ridge regression on the same sensors.
    pub ridge: ScoreParts,
    /// Scores of ridge regression on strain alone.
    pub ridge_strain_only: ScoreParts,
    /// The use that the networks make of the sensors of the unseen runs.
    pub sensor_use: InputUse,
    /// Relative scatter between all runs within the ranges of the mapping; `None` for a single run.
    pub seed_scatter: Option<f64>,
    /// Number of training runs.
    pub training_runs: usize,
    /// The scores of each network.
    pub sub_models: Vec<NetworkScores>,
}

impl Evaluation {
    /// Evaluates all mappings of a study on the data with which it was trained.
    ///
    /// # Errors
    /// If a state contains a value that is not finite, or the study is not one of the mappings of the paper.
    pub fn of_study(study: &Study, data: &PaperData) -> Result<Vec<Evaluation>> {
        let scores = study.evaluate(&data.dataset)?;
        let each = study.fits.iter().zip(&scores.fits);
        each.map(|(fit, scores)| Evaluation::new(fit, scores, data)).collect()
    }

    fn new(fit: &StudyFit, scores: &FitScores, data: &PaperData) -> Result<Evaluation> {
        let mapping = Mapping::from_fit(&fit.spec)?;
        let own =
            scores.members.iter().find(|member| member.method == NAME && member.role == MemberRole::Asked);
        let used = own.and_then(|own| scores.uses.get(&own.name));
        Ok(Evaluation {
            network: ScoreParts::new(scores, NAME, MemberRole::Asked),
            strain_only: ScoreParts::new(scores, NAME, MemberRole::CoordinateOnly),
            mean_curve: ScoreParts::new(scores, "mean-curve", MemberRole::Baseline),
            ridge: ScoreParts::new(scores, "ridge", MemberRole::Baseline),
            ridge_strain_only: ScoreParts::new(scores, "ridge", MemberRole::CoordinateOnly),
            sensor_use: used.cloned().unwrap_or_default(),
            seed_scatter: scatter(data, &mapping, mapping.output)?.map(|scatter| scatter.relative),
            training_runs: data.parts.training_runs.runs().len(),
            sub_models: own.map(|own| own.networks.clone()).unwrap_or_default(),
            mapping,
        })
    }

    /// Expected relative RMSE of the mean of the training runs on an unseen run.
    pub fn best_without_sensors(&self) -> Option<f64> {
        self.seed_scatter.map(|scatter| scatter * best_without_inputs(self.training_runs))
    }
}

/// Scatter of a quantity between all runs, within the ranges of a mapping.
pub(crate) fn scatter(
    data: &PaperData,
    mapping: &Mapping,
    quantity: PaperQuantity,
) -> Result<Option<Scatter>> {
    let runs: Vec<&RunStates> =
        data.parts.training_runs.runs().iter().chain(data.parts.unseen.runs()).collect();
    let (Some(first), Some(last)) = (mapping.sub_models.first(), mapping.sub_models.last()) else {
        return Ok(None);
    };
    let columns = quantity.columns(&data.bins);
    Scatter::new(&runs, PaperQuantity::DeviatorStrain.column(), &columns, [first.range[0], last.range[1]])
}
