//! `granum evaluate` of a study of any columns.

use std::path::PathBuf;

use granum_core::words;
use granum_learn::runs::RunRole;
use granum_learn::study::{PartScore, Study};
use granum_learn::{Dataset, Score};
use serde_json::{Value, json};

use super::records::{self, Recorded};
use super::relation::Relation;
use super::scores::percent_or_dash;
use super::study_scores::{use_as_json, use_line};
use super::train_study::dataset;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Scores the study in a folder on run folders.
pub fn run(
    context: &Context,
    study: &Study,
    (folder, folders): (&PathBuf, &[PathBuf]),
) -> Result<(), Failure> {
    let runs = records::read(context, folders, RunRole::Unseen)?;
    let all: Vec<&Recorded> = runs.iter().collect();
    let data = dataset(&all)?;
    let (mut results, mut lines, mut unseen) = (Vec::new(), Vec::new(), Vec::new());
    for (run, states) in runs.iter().zip(data.runs()) {
        let relation = Relation::new(run, Some(&study.runs));
        if let Some(warning) = relation.warning(&run.name) {
            context.warn(&warning);
        }
        if !relation.is_training() {
            unseen.push(states.clone());
        }
        let one = Dataset::new(vec![states.clone()])?;
        let scores: Vec<(&str, PartScore)> = study
            .members()
            .map(|member| Ok((member.name.as_str(), study.score_part(member, &one)?)))
            .collect::<Result<_, Failure>>()?;
        lines.extend(table(&run.name, &relation, &scores));
        let scores = scores.iter().map(|(name, score)| json!({ "name": name, "scores": score }));
        results.push(json!({
            "run": run.name,
            "seed": run.seed,
            "kind": relation.kind(),
            "differs_from_training": relation.differences_json(),
            "surrogates": scores.collect::<Vec<_>>(),
        }));
    }
    let mut uses = serde_json::Map::new();
    if !unseen.is_empty() {
        let unseen = Dataset::new(unseen)?;
        for fit in &study.fits {
            for (name, used) in study.uses(fit, &unseen)? {
                lines.push(use_line(&name, &used));
                uses.insert(name, use_as_json(&used));
            }
        }
    }
    let result = json!({ "study": output::path(folder), "runs": results, "uses": Value::Object(uses) });
    output::say(context, &result, || lines.join("\n"))
}

fn table(run: &str, relation: &Relation, scores: &[(&str, PartScore)]) -> Vec<String> {
    let width = scores.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let head = format!(
        "{:<width$} {:>13} {:>9} {:>11} {:>7} {:>8}",
        "surrogate", "relative RMSE", "R2", "in interval", "states", "outside"
    );
    let line = |(name, part): &(&str, PartScore)| {
        let Score { relative_rmse, r2, states, .. } = part.score;
        let held = part.coverage.map_or("-".into(), |share| words::percent(share, 0));
        let error = percent_or_dash(Some(relative_rmse));
        format!("{name:<width$} {error:>13} {r2:>9.4} {held:>11} {states:>7} {:>8}", part.outside)
    };
    let mut lines = vec![format!("{run}: {}", relation.kind()), head];
    lines.extend(scores.iter().map(line));
    lines.push(String::new());
    lines
}
