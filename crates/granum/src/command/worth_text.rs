//! What each soft sensor is worth, as lines of text.

use granum_learn::worth::{Answer, Worth};

/// The tables of each path.
pub fn lines(worth: &Worth) -> Vec<String> {
    let mut lines = Vec::new();
    for path in worth.paths() {
        let of_path = || worth.answers.iter().filter(|answer| answer.path == path);
        let runs = of_path().map(|answer| answer.training_runs).max().unwrap_or(0);
        let unseen = of_path().map(|answer| answer.error.runs).max().unwrap_or(0);
        let named = if path.is_empty() { String::new() } else { format!("{path}: ") };
        lines.push(format!(
            "{named}relative RMSE on {unseen} unseen runs, in percent, with its standard error over these runs; {runs} training runs"
        ));
        for outputs in [&worth.plan.outputs, &worth.plan.sensors] {
            lines.push(String::new());
            lines.extend(table(
                outputs,
                worth
                    .table(path, outputs)
                    .into_iter()
                    .map(|(name, row)| (name, row.into_iter().map(with_method).collect())),
            ));
        }
        for output in worth.plan.outputs.iter().chain(&worth.plan.sensors) {
            let (counts, rows) = worth.by_runs(path, output);
            if counts.len() > 1 {
                let heads: Vec<String> = counts.iter().map(|count| format!("{count} runs")).collect();
                lines.extend([String::new(), format!("{output} by the number of training runs")]);
                lines.extend(table(
                    &heads,
                    rows.into_iter().map(|(name, row)| (name, row.into_iter().map(plain).collect())),
                ));
            }
        }
        lines.push(String::new());
    }
    lines.extend(worth.remarks.iter().cloned());
    while lines.last().is_some_and(String::is_empty) {
        lines.pop();
    }
    lines
}

fn table<'a>(heads: &[String], rows: impl Iterator<Item = (&'a str, Vec<String>)>) -> Vec<String> {
    let rows: Vec<(&str, Vec<String>)> = rows.collect();
    let first = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let width = |k: usize| {
        let cells = rows.iter().map(|(_, cells)| cells[k].chars().count());
        cells.chain([heads[k].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let line = |name: &str, cells: &[String]| {
        let cells = cells.iter().zip(&widths).map(|(cell, width)| format!("  {cell:<width$}"));
        format!("{name:<first$}{}", cells.collect::<String>()).trim_end().to_string()
    };
    std::iter::once(line("known", heads)).chain(rows.iter().map(|(name, cells)| line(name, cells))).collect()
}

/// `13.7 ± 0.9 (boosted-trees)`.
fn with_method(answer: Option<&Answer>) -> String {
    answer.map_or("-".into(), |answer| format!("{} ({})", plain(Some(answer)), answer.method))
}

/// `13.7 ± 0.9`.
fn plain(answer: Option<&Answer>) -> String {
    let Some(Answer { error, .. }) = answer else { return "-".into() };
    let decimals = if error.relative < 0.0995 { 2 } else { 1 };
    format!("{:.decimals$} ± {:.decimals$}", 100.0 * error.relative, 100.0 * error.standard_error)
}
