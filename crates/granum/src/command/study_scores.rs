//! The scores of a study of any columns as lines of text and as JSON.

use granum_learn::input_use::InputUse;
use granum_learn::study::{FitScores, StudyScores};
use serde_json::{Value, json};

use super::scores::{percent_or_dash, points};

/// The scores of each fit, then the use of inputs.
pub fn lines(scores: &StudyScores) -> Vec<String> {
    let width =
        scores.fits.iter().flat_map(|fit| &fit.members).map(|member| member.name.len()).max().unwrap_or(0);
    let mut lines = vec![format!(
        "{:<width$} {:>8} {:>8} {:>8} {:>9} {:>11} {:>8}",
        "relative RMSE", "training", "held out", "unseen", "R2", "in interval", "outside"
    )];
    for member in scores.fits.iter().flat_map(|fit| &fit.members) {
        let some = |part: &granum_learn::study::PartScore| {
            percent_or_dash((part.score.states > 0).then_some(part.score.relative_rmse))
        };
        let unseen = &member.unseen;
        let r2 = if unseen.score.states > 0 { format!("{:.4}", unseen.score.r2) } else { "-".into() };
        lines.push(format!(
            "{:<width$} {} {} {} {r2:>9} {:>11} {:>8}",
            member.name,
            some(&member.training),
            some(&member.held_out),
            some(unseen),
            unseen.coverage.map_or("-".into(), |share| format!("{:.0} %", 100.0 * share)),
            unseen.outside
        ));
    }
    for (name, used) in scores.fits.iter().flat_map(|fit| &fit.uses) {
        lines.push(use_line(name, used));
    }
    lines
}

/// `y-ridge uses its inputs and gains by it: relative RMSE 1.0 % with its own inputs, 3.0 % with those of another run, ...`.
pub fn use_line(name: &str, used: &InputUse) -> String {
    let error = |score: Option<granum_learn::Score>| {
        percent_or_dash(score.map(|score| score.relative_rmse)).trim().to_owned()
    };
    let runs = used.runs.len();
    let plural = if runs == 1 { "" } else { "s" };
    let words = match used.verdict() {
        granum_learn::input_use::Verdict::TooFewRuns => {
            "whether it uses its inputs cannot be told from so few runs".into()
        }
        granum_learn::input_use::Verdict::DoesNotUse => "does not use its inputs".into(),
        verdict => verdict.words("inputs"),
    };
    format!(
        "{name}: {words}: relative RMSE {} with its own inputs, {} with those of another run, {} with permuted ones; use {}, \
         help {} percentage points over {runs} unseen run{plural}",
        error(used.own),
        error(used.with_other),
        error(used.permuted),
        points(used.lost_with_other()),
        points(used.help()),
    )
}

/// The scores of a fit, with the conclusions on the use of inputs.
pub fn as_json(fit: &FitScores) -> Value {
    json!({ "name": fit.name, "members": fit.members, "uses": uses_as_json(fit) })
}

fn uses_as_json(fit: &FitScores) -> Value {
    fit.uses
        .iter()
        .map(|(name, used)| (name.clone(), use_as_json(used)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// The use of inputs of one surrogate.
pub fn use_as_json(used: &InputUse) -> Value {
    json!({
        "own": used.own,
        "with_other": used.with_other,
        "permuted": used.permuted,
        "use": used.lost_with_other(),
        "use_against_permuted": used.lost_permuted(),
        "help": used.help(),
        "verdict": used.verdict().words("inputs"),
    })
}
