//! The scores of a study of any columns as lines of text and as JSON.

use granum_core::words;
use granum_learn::PooledError;
use granum_learn::input_use::InputUse;
use granum_learn::learning_curve::LearningCurve;
use granum_learn::networks::NetworkScores;
use granum_learn::study::{FitScores, MemberScores, StudyScores};
use serde_json::{Value, json};

use super::scores::{percent_or_dash, points};
use super::trained_range::short;

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
            unseen.coverage.map_or("-".into(), |share| words::percent(share, 0)),
            unseen.outside
        ));
    }
    for fit in &scores.fits {
        lines.extend(fit.members.iter().flat_map(network_lines));
    }
    lines.extend(scores.fits.iter().filter_map(best_line));
    lines.extend(scores.fits.iter().filter_map(scatter_line));
    for (name, used) in scores.fits.iter().flat_map(|fit| &fit.uses) {
        lines.push(use_line(name, used));
    }
    lines
}

/// `stress_ratio: the least error on 40 unseen runs has stress_ratio-gaussian-process (1.31 ± 0.08 %), before ...`.
fn best_line(fit: &FitScores) -> Option<String> {
    let named = |(member, error): &(&MemberScores, PooledError)| {
        let [mean, spread] =
            [error.relative, error.standard_error].map(|share| format!("{:.2}", 100.0 * share));
        format!("{} ({mean} ± {spread} %)", member.name)
    };
    let ranked = fit.ranked();
    let (best, others) = ranked.split_first()?;
    let runs = best.1.runs;
    let others: Vec<String> = others.iter().take(3).map(named).collect();
    let before = if others.is_empty() { String::new() } else { format!(", before {}", others.join(", ")) };
    let plural = if runs == 1 { "" } else { "s" };
    Some(format!("{}: the least error on {runs} unseen run{plural} has {}{before}", fit.name, named(best)))
}

/// One line for the network of each sub-model, if there is more than one.
fn network_lines(member: &MemberScores) -> Vec<String> {
    let line = |(k, network): (usize, &NetworkScores)| {
        let error = |score: &granum_learn::Score| {
            percent_or_dash((score.states > 0).then_some(score.relative_rmse)).trim().to_owned()
        };
        let constant = if network.constant { "; it predicts a constant: it has learned nothing" } else { "" };
        format!(
            "{} sub-model {} ({} to {}): relative RMSE {} held out, {} unseen{constant}",
            member.name,
            k + 1,
            short(network.range[0]),
            short(network.range[1]),
            error(&network.held_out),
            error(&network.unseen),
        )
    };
    match member.networks.len() {
        0 | 1 => Vec::new(),
        _ => member.networks.iter().enumerate().map(line).collect(),
    }
}

/// `stress_ratio: runs that differ only in their seed scatter by 3.1 % (4 runs), ...`.
fn scatter_line(fit: &FitScores) -> Option<String> {
    let scatter = fit.seed_scatter?;
    let groups = match scatter.groups {
        1 => String::new(),
        groups => format!(" in {groups} groups of equal parameters"),
    };
    let best = scatter.best_without_inputs.map_or(String::new(), |best| {
        format!(
            "; the mean of the training runs cannot be expected to be closer than {}",
            percent_or_dash(Some(best)).trim()
        )
    });
    Some(format!(
        "{}: runs that differ only in their seed scatter by {} ({} runs{groups}){best}",
        fit.name,
        percent_or_dash(Some(scatter.relative)).trim(),
        scatter.runs
    ))
}

/// The error of each surrogate as a function of the number of training runs.
pub fn learning_lines(curve: &LearningCurve) -> Vec<String> {
    let width = curve.points.iter().map(|point| point.fit.len() + point.method.len() + 1).max().unwrap_or(0);
    let mut lines = vec![format!(
        "{:<width$} {:>4} {:>8} {:>15} {:>8} {:>13}   {:>15} {:>15}",
        "learning curve", "runs", "unseen", "coordinate only", "ridge", "another run", "use", "help"
    )];
    for point in &curve.points {
        lines.push(format!(
            "{:<width$} {:>4} {} {:>15} {} {:>13}   {:>15} {:>15}",
            format!("{}-{}", point.fit, point.method),
            point.training_runs,
            percent_or_dash(Some(point.error.mean)),
            percent_or_dash(Some(point.coordinate_only.mean)),
            percent_or_dash(point.ridge.map(|ridge| ridge.mean)),
            percent_or_dash(point.with_other.map(|other| other.mean)),
            points(point.lost_with_other),
            points(Some(point.help)),
        ));
    }
    lines.push(format!(
        "relative RMSE on {} unseen runs; use: error with the inputs of another unseen run minus error with its own; help: error \
         from the coordinate alone minus that with all inputs; percentage points",
        curve.unseen_runs
    ));
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
    json!({
        "name": fit.name,
        "members": fit.members,
        "uses": uses_as_json(fit),
        "seed_scatter": fit.seed_scatter,
    })
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
