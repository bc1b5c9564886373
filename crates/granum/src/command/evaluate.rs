//! `granum evaluate`: the scores of a saved study on runs.

use std::path::PathBuf;

use clap::Args;
use granum_antony2006::evaluation::{score_run, scored_run, sensor_use};
use granum_antony2006::{RunScore, is_of_paper};
use granum_learn::input_use::InputUse;
use granum_learn::runs::RunRole;
use granum_learn::study::Study;
use granum_learn::{Dataset, RunStates, Score};
use serde_json::{Value, json};

use super::evaluate_study;
use super::records::{self, Recorded};
use super::relation::Relation;
use super::scores::{SensorRow, percent_or_dash, sensor_table};
use super::study_folder;
use super::train_family;
use super::train_study::dataset;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Score a study on runs: relative RMSE and R2 of its networks, compared with strain-only networks of the same size, ridge
/// regression and the mean curve of the training runs.
///
/// With two or more runs on which no network was trained, every run is also predicted with the sensor values of the other
/// runs; with three or more, a statistical test decides whether the networks use their sensors.
///
/// Scores on training runs are labelled as such, and for a run whose material, law or test differs from the training runs,
/// the keys that differ are printed.
///
/// With --family all folders are runs, and the surrogate of the family is scored on them: against the mean of runs that differ in their seed
/// alone, if there are such, and by the share of the states that its intervals hold.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum evaluate study run-2 run-3\n  granum evaluate --family sand study"
)]
pub struct Evaluate {
    /// Folder of the study, written by `granum train` (or the folder `models` of a reproduction).
    study: PathBuf,
    /// Run folders on which the study is scored.
    #[arg(required_unless_present = "family", value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Score this family, or a fitted family in a file (NAME.json), instead of a study.
    #[arg(long, value_name = "NAME")]
    family: Option<String>,
    /// Path of the tests of --family; its first one by default. Runs along other paths are left out.
    #[arg(long, value_name = "NAME", requires = "family")]
    path: Option<String>,
    /// Write the scores into the file of the fitted family, whose card then has them.
    #[arg(long, requires = "family")]
    keep: bool,
}

impl Evaluate {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("evaluating"));
        if let Some(family) = &self.family {
            let runs: Vec<PathBuf> = [&self.study].into_iter().chain(&self.runs).cloned().collect();
            let family = (family.as_str(), self.path.as_deref());
            return train_family::evaluate(context, family, &runs, self.keep);
        }
        let study = study_folder::load(context, &self.study)?;
        if !is_of_paper(&study.definition) {
            return evaluate_study::run(context, &study, (&self.study, &self.runs));
        }
        let runs = records::read(context, &self.runs, RunRole::Unseen)?;
        let data = dataset(&runs.iter().collect::<Vec<_>>())?;
        let mut scored = Vec::new();
        let mut unseen: Vec<RunStates> = Vec::new();
        for (run, states) in runs.into_iter().zip(data.runs()) {
            let states = scored_run(&study, states)?;
            let scores = score_run(&study, &states)?;
            let relation = Relation::new(&run, Some(&study.runs));
            if !relation.is_training() {
                unseen.push(states);
            }
            if let Some(warning) = relation.warning(&run.name) {
                context.warn(&warning);
            }
            scored.push((run, relation, scores));
        }
        let sensors = sensors(&study, &unseen)?;
        let runs: Vec<Value> = scored
            .iter()
            .map(|(run, relation, scores)| {
                let scores: Vec<Value> = scores.iter().map(as_json).collect();
                json!({
                    "run": run.name,
                    "seed": run.seed,
                    "kind": relation.kind(),
                    "differs_from_training": relation.differences_json(),
                    "mappings": scores,
                })
            })
            .collect();
        let result = json!({
            "study": output::path(&self.study),
            "runs": runs,
            "sensors": sensors.iter().map(sensors_as_json).collect::<Vec<_>>(),
        });
        output::say(context, &result, || {
            let tables = scored.iter().map(|(run, relation, scores)| table(run, relation, scores));
            let mut parts: Vec<String> = tables.collect();
            if !sensors.is_empty() {
                let rows: Vec<SensorRow> = sensors.iter().map(sensor_row).collect();
                parts.push(sensor_table(&rows).join("\n"));
            }
            parts.join("\n\n")
        })
    }
}

/// The use that each mapping makes of the sensors of unseen runs; empty without unseen runs.
fn sensors(study: &Study, unseen: &[RunStates]) -> Result<Vec<(String, InputUse)>, Failure> {
    if unseen.is_empty() {
        return Ok(Vec::new());
    }
    Ok(sensor_use(study, &Dataset::new(unseen.to_vec())?)?)
}

fn sensor_row((name, sensors): &(String, InputUse)) -> SensorRow {
    let relative = |score: Option<Score>| score.map(|score| score.relative_rmse);
    SensorRow {
        name: name.clone(),
        own: relative(sensors.own),
        with_other: relative(sensors.with_other),
        permuted: relative(sensors.permuted),
        lost: sensors.lost_with_other(),
        help: sensors.help(),
        verdict: sensors.verdict().to_string(),
    }
}

fn sensors_as_json((name, sensors): &(String, InputUse)) -> Value {
    json!({
        "mapping": name,
        "network": sensors.own,
        "with_other_sensors": sensors.with_other,
        "with_permuted_sensors": sensors.permuted,
        "use": sensors.lost_with_other(),
        "use_against_permuted": sensors.lost_permuted(),
        "help": sensors.help(),
        "verdict": sensors.verdict(),
    })
}

/// The score, or `None` if no state was in the range of the mapping.
fn some(score: &Score) -> Option<&Score> {
    (score.states > 0).then_some(score)
}

fn as_json(score: &RunScore) -> Value {
    json!({
        "mapping": score.mapping,
        "network": some(&score.network),
        "strain_only": some(&score.strain_only),
        "ridge": score.ridge.as_ref().and_then(some),
        "ridge_strain_only": score.ridge_strain_only.as_ref().and_then(some),
        "mean_curve": score.mean_curve.as_ref().and_then(some),
        "states_outside": score.states_outside,
    })
}

fn table(run: &Recorded, relation: &Relation, scores: &[RunScore]) -> String {
    let sample = run.seed.map_or_else(|| "of a packing".to_string(), |seed| format!("seed {seed}"));
    let mut lines = vec![
        format!("{} ({sample}): {}", run.name, relation.kind()),
        format!(
            "{:<8} {:>13} {:>8}   {:>13} {:>8}   {:>8} {:>18} {:>10}   {:>7} {:>8}",
            "mapping",
            "relative RMSE",
            "R2",
            "strain only",
            "R2",
            "ridge",
            "ridge, strain only",
            "mean curve",
            "states",
            "outside"
        ),
    ];
    let r2 = |score: &Score| some(score).map_or("-".to_string(), |score| format!("{:.4}", score.r2));
    let relative = |score: &Score| percent_or_dash(some(score).map(|score| score.relative_rmse));
    let baseline = |score: &Option<Score>| {
        percent_or_dash(score.as_ref().and_then(some).map(|score| score.relative_rmse))
    };
    for score in scores {
        lines.push(format!(
            "{:<8} {:>13} {:>8}   {:>13} {:>8}   {} {:>18} {:>10}   {:>7} {:>8}",
            score.mapping,
            relative(&score.network),
            r2(&score.network),
            relative(&score.strain_only),
            r2(&score.strain_only),
            baseline(&score.ridge),
            baseline(&score.ridge_strain_only),
            baseline(&score.mean_curve),
            score.network.states,
            score.states_outside,
        ));
    }
    if scores.iter().any(|score| score.states_outside > 0) {
        lines.push("outside: states with a strain or another input outside the trained range".into());
    }
    lines.join("\n")
}
