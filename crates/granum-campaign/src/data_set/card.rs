//! The card of a data set: what it is, in words.

use granum_core::quantity::format_number;
use granum_io::safe_text::{line, markdown, markdown_code};
use granum_io::{Column, ColumnKind};

use super::layout::VARIABLE;
use super::meaning;
use super::written::Written;

/// Number of runs that are named for one reason.
const MOST_NAMED: usize = 50;

/// The text of the card.
pub(super) fn text(written: &Written) -> String {
    let parts = [
        head(written),
        how_to_read(),
        which_runs(written),
        variables(written),
        files(),
        run_columns(written),
        state_columns(written),
    ];
    parts.join("\n")
}

fn head(written: &Written) -> String {
    let (runs, version) = (written.contents.taken.len(), written.campaign.version());
    format!(
        "# Element tests of granular materials, simulated grain by grain\n\n\
         {runs} tests with {} recorded states in all, simulated with the discrete element method (granum {version}): samples of\n\
         grains in a periodic cell are prepared and loaded along a path, and stress, strain, fabric, contact forces and energy are\n\
         recorded. Each row of `runs.parquet` is a test with all of its inputs, each row of `states.parquet` a state of a test.\n\n\
         - Stress and strain are positive in compression. All numbers are in SI units, angles in degrees.\n\
         - A result depends on the inputs in this table alone, not on the computer: the same plan gives these files again, bit by bit.\n\
         - SHA-256 over the content (of `runs.parquet` and `states.parquet`): `{}`\n",
        written.rows, written.digest
    )
}

fn how_to_read() -> String {
    "## How to read it\n\n```python\n\
     import pandas\n\
     runs = pandas.read_parquet(\"runs.parquet\").set_index(\"run\")\n\
     states = pandas.read_parquet(\"states.parquet\")\n\
     one = states[states.run == runs.index[0]]                    # a test\n\
     all = states.join(runs.filter(like=\"variable.\"), on=\"run\")  # the inputs beside the states\n\
     ```\n\n\
     polars: `polars.read_parquet(\"states.parquet\")`; DuckDB: `SELECT * FROM 'states.parquet' JOIN 'runs.parquet' USING (run)`;\n\
     granum: `granum train . --input ... --output ...`. Split by runs, never by states: those of one test are alike.\n\
     `sha256sum -c SHA256SUMS` compares the files.\n"
        .into()
}

fn which_runs(written: &Written) -> String {
    let contents = written.contents;
    let planned = written.campaign.runs().len();
    let mut lines = vec![format!(
        "## Which runs\n\nThe plan has {planned} runs; {} are in this data set.",
        contents.taken.len()
    )];
    let flagged_in = written
        .runs
        .values("passed")
        .map_or(0, |passed| passed.iter().filter(|value| **value == 0.0).count());
    if flagged_in > 0 {
        let accept: Vec<String> =
            written.campaign.accept().iter().map(|condition| markdown_code(condition.text())).collect();
        lines.push(format!(
            "{flagged_in} of these did not pass every check and are accepted by the plan ({}); `failed_checks` names their checks.",
            accept.join(", ")
        ));
    }
    for (state, what) in [
        ("flagged", "did not pass a check and are left out"),
        ("failed", "failed"),
        ("unfinished", "are not finished"),
    ] {
        let names: Vec<&str> = contents
            .left_out
            .iter()
            .filter(|run| run.state == state)
            .map(|run| written.campaign.runs()[run.number].name.as_str())
            .collect();
        if !names.is_empty() {
            lines.push(format!("{} {what}: {}.", names.len(), named(&names)));
        }
    }
    if contents.left_out.is_empty() {
        lines.push("None was left out.".into());
    } else {
        lines.push("`left_out.csv` has them with their inputs.".into());
    }
    lines.join("\n\n") + "\n"
}

fn named(names: &[&str]) -> String {
    let shown = names.iter().take(MOST_NAMED).copied().collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

fn variables(written: &Written) -> String {
    let mut lines = vec![
        "## What was varied\n".to_string(),
        "| variable | column | keys of the case | values |".into(),
        "|---|---|---|---|".into(),
    ];
    for variable in written.campaign.variables() {
        let column = format!("{VARIABLE}{}", variable.name);
        let values = written.runs.get(&column).map(values).unwrap_or_default();
        let scale = if variable.logarithmic { ", on a logarithmic scale" } else { "" };
        lines.push(format!(
            "| {} | {} | {} | {values}{scale} |",
            markdown(&variable.name),
            markdown_code(&column),
            markdown(&variable.keys.join(", "))
        ));
    }
    lines.join("\n") + "\n"
}

/// The values of a column in words.
fn values(column: &Column) -> String {
    let unit = if column.unit.is_empty() { String::new() } else { format!(" {}", markdown(&column.unit)) };
    if column.has_words() {
        let mut words = column.words.clone();
        words.sort();
        let all = words.len();
        words.truncate(8);
        let more = if all > 8 { format!(" and {} more", all - 8) } else { String::new() };
        let words: Vec<String> = words.iter().map(|word| markdown(word)).collect();
        return format!("{}{more}", words.join(", "));
    }
    let finite = || column.values.iter().copied().filter(|value| value.is_finite());
    let [low, high] = [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)];
    if low > high {
        return "no number".into();
    }
    match low == high {
        true => format!("{}{unit}", rounded(low)),
        false => format!("{} to {}{unit}", rounded(low), rounded(high)),
    }
}

/// A number with five digits.
fn rounded(number: f64) -> String {
    format_number(format!("{number:.4e}").parse().unwrap_or(number))
}

fn files() -> String {
    "## Files\n\n| file | content |\n|---|---|\n\
     | `runs.parquet` | a row for each run |\n\
     | `states.parquet` | a row for each recorded state; histograms are columns of lists, a number for each bin |\n\
     | `left_out.csv` | the runs that are not part of the data set, if there are any: `flagged`, `failed` or `unfinished` |\n\
     | `case.toml` | the base case; with the column `settings` it gives the case of every run |\n\
     | `metadata.json` | this description for programs (Croissant) |\n\
     | `SHA256SUMS` | SHA-256 of the files above |\n\
     | `seconds.parquet` | wall times and machines, which differ from computer to computer and which no sum covers |\n"
        .into()
}

fn run_columns(written: &Written) -> String {
    let mut lines = vec![
        "## Columns of `runs.parquet`\n\n`variable.` are the variables of the plan, `sample.` what was measured on the sample before the \
         test, `measure.` measures of the sample and the test, `check.` the quality checks; other columns with a dot are keys of the case.\n"
            .to_string(),
        "| column | unit | values | meaning |".into(),
        "|---|---|---|---|".into(),
    ];
    for column in written.runs.columns() {
        let values = match column.kind {
            ColumnKind::Word if column.words.len() > 8 => "words".into(),
            _ if column.name == "settings" || column.name.ends_with("digest") => "words".into(),
            _ => values(column),
        };
        lines.push(format!(
            "| {} | {} | {values} | {} |",
            markdown_code(&column.name),
            markdown(&column.unit),
            meaning(written, &column.name)
        ));
    }
    lines.join("\n") + "\n"
}

fn state_columns(written: &Written) -> String {
    let mut lines = vec![
        "## Columns of `states.parquet`\n".to_string(),
        "| column | unit | meaning |".into(),
        "|---|---|---|".into(),
    ];
    for column in written.states.table.columns() {
        let (name, unit) = (markdown_code(&column.name), markdown(&column.unit));
        lines.push(format!("| {name} | {unit} | {} |", meaning(written, &column.name)));
    }
    for list in &written.states.lists {
        let (name, unit) = (markdown_code(&list.name), markdown(&list.unit));
        lines.push(format!("| {name} | {unit} | list: {} |", line(&meaning::of_list(&list.name))));
    }
    lines.join("\n") + "\n"
}

fn meaning(written: &Written, name: &str) -> String {
    let campaign = written.campaign;
    let meaning = meaning::of_column(name, campaign.base(), campaign.sensors());
    line(&meaning.replace('\n', " ")).replace('|', "\\|").replace('<', "&lt;")
}
