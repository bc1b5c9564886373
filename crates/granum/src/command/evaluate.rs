//! `granum evaluate`: a saved study against runs.

use std::path::PathBuf;

use clap::Args;
use granum_hybrid::Score;
use granum_hybrid::files::{load_runs, load_study};
use granum_hybrid::runs::RunRole;
use granum_hybrid::study::RunScore;
use serde_json::{Value, json};

use super::records::{self, Recorded};
use super::relation::Relation;
use super::scores::percent;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Score a study on runs: relative RMSE and R2 of its networks, beside networks of the same sizes that see strain only.
///
/// Scores on a run that the networks were trained on are called so, and a run of another material, law or test than the
/// training runs is told with the keys that differ.
#[derive(Args)]
#[command(after_help = "Example:\n  granum evaluate study run-2 run-3")]
pub struct Evaluate {
    /// Folder of the study that `granum train` left (or `models` of a reproduction).
    study: PathBuf,
    /// Run folders to judge by.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
}

impl Evaluate {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let study = load_study(&self.study)?;
        let known = load_runs(&self.study)?;
        let mut scored = Vec::new();
        for run in records::read(context, &self.runs, RunRole::Unseen)? {
            let scores = study.score_run(&study.read(&run.named())?)?;
            let relation = Relation::of(&run, known.as_deref());
            if let Some(warning) = relation.warning(&run.name) {
                context.warn(&warning);
            }
            scored.push((run, relation, scores));
        }
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
        let result = json!({ "study": self.study, "runs": runs });
        output::say(context, &result, || {
            let tables = scored.iter().map(|(run, relation, scores)| table(run, relation, scores));
            tables.collect::<Vec<_>>().join("\n\n")
        })
    }
}

/// A score, or nothing where no state lay in the range of the mapping.
fn some(score: &Score) -> Option<&Score> {
    (score.states > 0).then_some(score)
}

fn as_json(score: &RunScore) -> Value {
    json!({
        "mapping": score.mapping,
        "network": some(&score.network),
        "strain_only": some(&score.strain_only),
        "states_outside": score.states_outside,
    })
}

fn table(run: &Recorded, relation: &Relation, scores: &[RunScore]) -> String {
    let sample = run.seed.map_or_else(|| "of a packing".to_string(), |seed| format!("seed {seed}"));
    let mut lines = vec![
        format!("{} ({sample}): {}", run.name, relation.kind()),
        format!(
            "{:<8} {:>13} {:>8}   {:>13} {:>8}   {:>7} {:>8}",
            "mapping", "relative RMSE", "R2", "strain only", "R2", "states", "outside"
        ),
    ];
    let r2 = |score: &Score| some(score).map_or("-".to_string(), |score| format!("{:.4}", score.r2));
    let relative = |score: &Score| percent(some(score).map(|score| score.relative_rmse));
    for score in scores {
        lines.push(format!(
            "{:<8} {:>13} {:>8}   {:>13} {:>8}   {:>7} {:>8}",
            score.mapping,
            relative(&score.network),
            r2(&score.network),
            relative(&score.strain_only),
            r2(&score.strain_only),
            score.network.states,
            score.states_outside,
        ));
    }
    if scores.iter().any(|score| score.states_outside > 0) {
        lines.push("outside: states with strain or an input beyond what the networks were trained on".into());
    }
    lines.join("\n")
}
