//! The mappings of Antony, Zhou and Wang (2006): the networks of one are trained on runs that a page has made, and answer beside runs that they have
//! not seen.

use granum_antony2006::figures::figures;
use granum_antony2006::interpretation::read_mapping;
use granum_antony2006::report::mapping_figure;
use granum_antony2006::{
    Evaluation, Mapping, PaperData, PaperDataOptions, PaperOptions, PaperQuantity, evaluation, paper_mapping,
    paper_mappings,
};
use granum_io::Case;
use granum_learn::Surrogate;
use granum_learn::curve::RunCurves;
use granum_learn::dataset::RunStates;
use granum_learn::networks::SubModelNetworks;
use granum_learn::score::Score;
use granum_learn::study::{NoStudyObserver, Study};
use serde_json::{Value, json};

use super::case::NAME;
use super::reports::{Received, measurements};
use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// A mapping with its networks, and the runs that they have learned from and not.
struct TrainedMapping {
    mapping: Mapping,
    data: PaperData,
    study: Study,
}

/// The mappings of the paper, with the ranges and neurons of their networks.
pub(super) fn mappings(_: &mut Page, _: &Arguments) -> Result<Value, CallError> {
    let shown = |mapping: &Mapping| {
        json!({
            "name": mapping.name, "formula": mapping.formula(),
            "networks": mapping.sub_models.iter().map(|one| json!({ "range": one.range, "hidden": one.hidden })).collect::<Vec<_>>(),
        })
    };
    Ok(json!({ "mappings": paper_mappings().iter().map(shown).collect::<Vec<_>>() }))
}

/// Trains the networks of the `mapping` of that name on the results of the runs in `training`, and scores them on those in `unseen`, beside networks
/// that are given the strain alone and the baselines of the study; with `neurons` in every hidden layer where that is given.
pub(super) fn train(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let mut mapping = paper_mapping(arguments.text("mapping")?)?;
    let neurons = arguments.number_or("neurons", 0.0).clamp(0.0, 200.0) as usize;
    if neurons > 0 {
        mapping = mapping.with_neurons(neurons);
    }
    let (training, unseen) = (runs(page, arguments, "training")?, runs(page, arguments, "unseen")?);
    let data = PaperData::new(training, unseen, &PaperDataOptions::default())?;
    let options = PaperOptions { mappings: vec![mapping.clone()], threads: 1, ..PaperOptions::default() };
    let study = options.train(&data, &NoStudyObserver)?;
    let found = Evaluation::of_study(&study, &data)?;
    let drawn = figures(&study, &data)?;
    let (Some(found), Some(drawn)) = (found.first(), drawn.first()) else {
        return Err(CallError::Message("the study has no mapping".into()));
    };
    let (figure, caption) = mapping_figure(drawn);
    let error = |score: Score| (score.states > 0).then_some(score.relative_rmse);
    let answer = json!({
        "name": mapping.name, "formula": mapping.formula(), "figure": figure.to_svg(), "caption": caption,
        "summary": read_mapping(found),
        "errors": {
            "networks": error(found.network.unseen), "strain_only": error(found.strain_only.unseen),
            "ridge": error(found.ridge.unseen), "ridge_strain_only": error(found.ridge_strain_only.unseen),
            "mean_curve": error(found.mean_curve.unseen), "on_training_states": error(found.network.training),
        },
        "training_states": data.parts.training.rows(), "unseen_states": data.parts.unseen.rows(),
        "forces": data.bins.centres,
        "runs": data.dataset.runs().iter().map(RunStates::name).collect::<Vec<_>>(),
        "inputs": inputs(&mapping, &data)?,
    });
    page.trained = Some(Box::new(TrainedMapping { mapping, data, study }));
    Ok(answer)
}

/// What the trained networks answer to the state of a `run` at a `strain`, where numbers in `values` stand in the place of its own; what networks answer
/// that are given the strain alone; and what was measured.
pub(super) fn answer(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let none = || CallError::Message("no mapping is trained; train one first".into());
    let trained: &TrainedMapping =
        page.trained.as_ref().and_then(|kept| kept.downcast_ref()).ok_or_else(none)?;
    let (mapping, name) = (&trained.mapping, arguments.text("run")?);
    let known = trained.data.dataset.runs();
    let run = known.iter().find(|run| run.name() == name);
    let run = run.ok_or_else(|| CallError::Message(format!("there is no run {name:?}")))?;
    let [low, high] = strains(mapping, &trained.data);
    let strain = arguments.number_or("strain", high).clamp(low, high);
    let values = arguments.numbers("values");
    let networks = evaluation::networks(&trained.study, &mapping.name)?;
    let names = Surrogate::columns(networks).input_names();
    let mut row = at(run, &names, strain)?;
    for (value, name) in row.iter_mut().zip(&names).skip(1) {
        *value = values.get(name).copied().unwrap_or(*value);
    }
    let [answered, of_strain] =
        [(networks, row.clone()), (evaluation::strain_only(&trained.study, &mapping.name)?, vec![strain])]
            .map(|(networks, row)| predicted(networks, &row));
    let ((answered, outside), (of_strain, _)) = (answered?, of_strain?);
    let measured = at(run, &mapping.output.columns(&trained.data.bins), strain)?;
    Ok(json!({
        "strain": strain, "networks": answered, "strain_only": of_strain, "measured": measured, "outside": outside,
        "network": mapping.sub_model_at(strain).0 + 1,
        "inputs": names.iter().zip(row).map(|(name, value)| json!({ "name": name, "value": value })).collect::<Vec<_>>(),
    }))
}

/// The results of a list, as runs of these names.
fn runs(page: &Page, arguments: &Arguments, which: &str) -> Result<Vec<RunStates>, CallError> {
    let none = || CallError::Message(format!("the call needs a list {which:?} of results with their names"));
    let run = |one: &Value| -> Result<RunStates, CallError> {
        let name = one["name"].as_str().ok_or_else(none)?;
        let result = Received::from_value(&one["result"])?;
        let case = Case::parse(result.case(), NAME)?;
        Ok(RunStates::of_case(name, &case, measurements(page, &result)?)?)
    };
    arguments.value(which).as_array().ok_or_else(none)?.iter().map(run).collect()
}

/// The strains that the networks of a mapping and all of its runs have.
fn strains(mapping: &Mapping, data: &PaperData) -> [f64; 2] {
    let ends = |run: &RunStates| {
        let strains = run.column(PaperQuantity::DeviatorStrain.column()).unwrap_or_default();
        [strains.get(1).copied().unwrap_or(0.0), strains.last().copied().unwrap_or(0.0)]
    };
    let last = mapping.sub_models.last().map_or(0.0, |one| one.range[1]);
    data.dataset.runs().iter().map(ends).fold([0.0, last], |[low, high], [a, b]| [low.max(a), high.min(b)])
}

/// The strain and the other single numbers among the inputs, with their ranges over all runs.
fn inputs(mapping: &Mapping, data: &PaperData) -> Result<Vec<Value>, CallError> {
    let single = mapping.inputs.iter().filter(|input| **input != PaperQuantity::ForceDistribution);
    let input = |input: &PaperQuantity| -> Result<Value, CallError> {
        let range = match input {
            PaperQuantity::DeviatorStrain => strains(mapping, data),
            _ => {
                let columns = data.dataset.runs().iter().map(|run| run.column(input.column()));
                let columns = columns.collect::<Result<Vec<_>, _>>()?;
                granum_learn::curve::range(columns.iter().flatten().copied())
            }
        };
        Ok(json!({ "name": input.column(), "symbol": input.symbol(), "range": range }))
    };
    single.map(input).collect()
}

/// The columns of a run at a strain, on straight lines between its states.
fn at(run: &RunStates, columns: &[String], strain: f64) -> Result<Vec<f64>, CallError> {
    Ok(RunCurves::new(run, PaperQuantity::DeviatorStrain.column(), columns)?.at(strain))
}

/// What networks answer to the inputs of a state, and whether these are outside of what they were trained with.
fn predicted(networks: &SubModelNetworks, row: &[f64]) -> Result<(Vec<f64>, bool), CallError> {
    let found = networks.predict_states(row)?.pop();
    Ok(found.map(|state| (state.values, state.outside)).unwrap_or_default())
}
