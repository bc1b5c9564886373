//! The card of a fitted family: how it was made, how good it is, where not to use it.

use granum_core::words;
use granum_learn::family::{FamilyModel, FamilyOutputScore, FamilyScores};
use serde_json::{Value, json};

use super::family_chart::short;

/// The card in Markdown.
pub fn text(model: &FamilyModel) -> String {
    let family = model.definition();
    let mut lines = vec![format!("# {}: {}\n", family.name, family.title)];
    lines.extend(family.about.iter().map(|sentence| format!("- {sentence}")));
    let data: Vec<String> = model
        .data()
        .iter()
        .map(|data| format!("{} ({} runs, SHA-256 {})", data.name, data.runs, data.digest))
        .collect();
    lines.push(format!(
        "- Fitted to {} runs: {}. They are those of the plan `{}` (`granum init --plan {}`).",
        model.runs(),
        data.join(", "),
        family.plan,
        family.plan
    ));
    if !model.left_out().is_empty() {
        let each: Vec<String> =
            model.left_out().iter().map(|early| format!("{} ({})", early.run, short(early.end))).collect();
        let coordinate = family.coordinate.replace('_', " ");
        lines.push(format!(
            "- Left out since they end early, at the {coordinate} given: {}.",
            each.join(", ")
        ));
    }
    lines.push("\n## Inputs\n".into());
    let rows = family.inputs.iter().zip(model.ranges()).map(|(input, [low, high])| {
        vec![input.name.to_string(), short(low), short(high), input.meaning.to_string()]
    });
    lines.push(markdown(&["input", "from", "to", "meaning"], rows.collect()));
    for scores in model.scores() {
        lines.extend(score_lines(scores));
    }
    if model.scores().is_empty() {
        lines.push("\nIt has not been scored on unseen runs.".into());
    }
    lines.push("\n## Where not to use it\n".into());
    lines.extend(family.limits.iter().map(|sentence| format!("- {sentence}")));
    lines.join("\n")
}

/// The scores on some runs as lines.
pub fn score_lines(scores: &FamilyScores) -> Vec<String> {
    let FamilyScores { data, points, outside, left_out, level, outputs } = scores;
    let materials = match points {
        0 => "each of a material of its own".to_string(),
        points => format!("{points} materials with several samples"),
    };
    let mut lines = vec![format!("\n## On unseen runs: {} ({} runs, {materials})\n", data.name, data.runs)];
    let percent = |value: f64| if value.is_finite() { words::percent(value, 1) } else { "-".into() };
    let ratio = |value: f64| if value.is_finite() { format!("{value:.2}") } else { "-".into() };
    let row = |output: &FamilyOutputScore| {
        let worst = output
            .quarters
            .iter()
            .flat_map(|quarter| {
                let each = quarter.held.iter().zip(&quarter.standard_errors);
                each.filter_map(|(held, error)| Some((quarter.input.as_str(), (*held)?, *error)))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        vec![
            output.output.clone(),
            percent(output.relative_error),
            percent(output.relative_scatter),
            ratio(output.net_error),
            ratio(output.standard_error),
            percent(output.held),
            percent(output.whole_curves),
            worst.map_or_else(
                || "-".into(),
                |(input, held, error)| match error {
                    Some(error) => format!("{:.1} ± {:.1} % ({input})", 100.0 * held, 100.0 * error),
                    None => format!("{} ({input})", percent(held)),
                },
            ),
        ]
    };
    let heads = [
        "output",
        "error",
        "scatter",
        "net error / scatter",
        "standard error",
        "states held",
        "whole curves held",
        "worst quarter",
    ];
    lines.push(markdown(&heads, outputs.iter().map(row).collect()));
    lines.push(format!(
        "\nError: root mean square for a single run, over that of its values. Scatter: of runs that differ in their seed alone. Net error: \
         the mean error over such runs, less what chance leaves of it, over the scatter of one run; one more run would have 1. Held: within \
         intervals, or bands for whole curves, of {:.0} %. Worst quarter: of the range of an input, with the standard error over materials.",
        100.0 * level
    ));
    if *outside > 0 {
        let within = outputs.iter().filter_map(|own| Some((own.output.as_str(), own.held_within?)));
        let within: Vec<String> = within.map(|(name, held)| format!("{} ({name})", percent(held))).collect();
        let of_others = match within.is_empty() {
            true => String::new(),
            false => format!(" Of the states of the other runs the intervals hold {}.", within.join(", ")),
        };
        lines.push(format!(
            "{outside} of the runs are flagged: they have an input outside the ranges, or two that the runs of the fit do not have together.{of_others}"
        ));
    }
    if !left_out.is_empty() {
        lines.push(format!("Not scored since they end early: {}.", left_out.join(", ")));
    }
    lines
}

/// The card for programs.
pub fn as_json(model: &FamilyModel) -> Value {
    let family = model.definition();
    let early = model.left_out().iter().map(|early| json!({ "run": early.run, "end": early.end }));
    let inputs = family.inputs.iter().zip(model.ranges());
    let inputs =
        inputs.map(|(input, range)| json!({ "input": input.name, "meaning": input.meaning, "range": range }));
    json!({
        "family": family.name,
        "title": family.title,
        "about": family.about,
        "limits": family.limits,
        "plan": family.plan,
        "runs": model.runs(),
        "data": model.data(),
        "left_out": early.collect::<Vec<_>>(),
        "inputs": inputs.collect::<Vec<_>>(),
        "scores": model.scores(),
    })
}

/// A table in Markdown with aligned columns.
fn markdown(heads: &[&str], rows: Vec<Vec<String>>) -> String {
    let width = |k: usize| {
        let cells = rows.iter().map(|row| row[k].chars().count());
        cells.chain([heads[k].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let line = |cells: Vec<&str>| {
        let padded = cells.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        format!("| {} |", padded.collect::<Vec<_>>().join(" | "))
    };
    let rule: Vec<String> = widths.iter().map(|width| "-".repeat(*width)).collect();
    let mut lines = vec![line(heads.to_vec()), line(rule.iter().map(String::as_str).collect())];
    lines.extend(rows.iter().map(|row| line(row.iter().map(String::as_str).collect())));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_markdown_with_aligned_columns() {
        let rows = vec![vec!["a".to_string(), "12.5 %".into()], vec!["long".into(), "-".into()]];
        let expected = "| name | held   |\n| ---- | ------ |\n| a    | 12.5 % |\n| long | -      |";
        assert_eq!(markdown(&["name", "held"], rows), expected);
    }
}
