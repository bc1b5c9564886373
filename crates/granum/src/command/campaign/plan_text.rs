//! A plan and its runs as text.

use granum_campaign::plan::{
    DesignKind, Plan, PlanVariable, PlannedRuns, RunValue, SampleSeeds, VariableKind,
};
use granum_core::quantity::format_number;
use granum_core::{Column, Table};
use granum_io::safe_text;
use granum_io::shell::ShowPath;
use serde_json::{Map, Value, json};

use crate::command::text_table;

/// Number of runs that are shown.
const SHOWN: usize = 8;
/// The column of the seeds.
const SEED: &str = "seed";

/// What a plan will run.
pub fn text(plan: &Plan, planned: &PlannedRuns) -> String {
    let mut lines =
        vec![format!("{} runs: {} of {}", planned.runs.len(), design(plan), plan.case_file.shown())];
    if planned.left_out > 0 {
        lines.push(format!("  the constraints left out {} points", planned.left_out));
    }
    if planned.repeated > 0 {
        lines.push(format!(
            "  {} points gave a case that another one has, which is run once",
            planned.repeated
        ));
    }
    lines.extend(plan.replaced_tests(planned).into_iter().map(|text| format!("  {text}")));
    lines.push("variables:".into());
    let width = plan.variables.iter().map(|variable| variable.name.len()).max().unwrap_or(0);
    lines.extend(
        plan.variables.iter().map(|variable| format!("  {:<width$}  {}", variable.name, described(variable))),
    );
    lines.push("runs:".into());
    lines.extend(text_table::lines(&table(plan, planned)).into_iter().map(|line| format!("  {line}")));
    if planned.runs.len() > SHOWN {
        lines.push(format!("  and {} more; all of them: --json", planned.runs.len() - SHOWN));
    }
    lines.join("\n")
}

/// The design in words.
fn design(plan: &Plan) -> String {
    let design = &plan.design;
    let what = match &design.kind {
        DesignKind::Points(design) => design.points_in_words,
        DesignKind::Chosen(_) => "chosen points of a Sobol sequence",
        DesignKind::Rows(_) => "listed points",
    };
    let seeds = match (design.replicates, design.sample_seeds) {
        (1, SampleSeeds::Same) => String::new(),
        (1, SampleSeeds::Different) => ", each with a sample of its own seed".into(),
        (count, SampleSeeds::Same) => format!(", {count} seeds each"),
        (count, SampleSeeds::Different) => format!(", {count} seeds each, no two runs the same"),
    };
    format!("{what}{seeds}")
}

fn described(variable: &PlanVariable) -> String {
    let unit = if variable.unit.is_empty() { String::new() } else { format!(" {}", variable.unit) };
    let values = match &variable.kind {
        VariableKind::Range { between: [from, to], logarithmic, .. } => {
            let scale = if *logarithmic { ", logarithmic" } else { "" };
            format!("{} to {}{unit}{scale}", format_number(*from), format_number(*to))
        }
        VariableKind::Choice(choices) => {
            choices.iter().map(|choice| safe_text::line(&choice.name)).collect::<Vec<_>>().join(", ")
        }
        VariableKind::Expression(expression) => safe_text::quoted(expression.value.text()),
        VariableKind::Given => "as listed".into(),
    };
    match &variable.keys[..] {
        [] => values,
        keys => {
            let keys: Vec<&str> = keys.iter().map(|key| key.value.as_str()).collect();
            format!("{values}  -> {}", keys.join(", "))
        }
    }
}

/// The first runs with their values.
fn table(plan: &Plan, planned: &PlannedRuns) -> Table {
    let shown = &planned.runs[..planned.runs.len().min(SHOWN)];
    let mut columns = vec![Column::of_words("name", shown.iter().map(|run| run.name.clone()))];
    for (k, variable) in plan.variables.iter().enumerate() {
        let values: Vec<&RunValue> = shown.iter().map(|run| &run.values[k].1).collect();
        columns.push(match values.iter().map(|value| value.number()).collect::<Option<Vec<f64>>>() {
            Some(numbers) => Column::new(&variable.name, &variable.unit, numbers),
            None => Column::of_words(&variable.name, values.iter().map(ToString::to_string)),
        });
    }
    let has_seeds = plan.design.replicates > 1 || plan.design.sample_seeds == SampleSeeds::Different;
    if has_seeds && plan.variables.iter().all(|variable| variable.name != SEED) {
        let seeds = shown.iter().map(|run| run.case.preparation.seed as f64).collect();
        columns.push(Column::new(SEED, "", seeds));
    }
    // Names are unique: a plan has none twice, and no variable is called name.
    Table::new(columns).unwrap_or_default()
}

/// The runs as JSON.
pub fn as_json(plan: &Plan, planned: &PlannedRuns) -> Value {
    let run = |run: &granum_campaign::plan::PlanRun| {
        let values: Map<String, Value> =
            run.values.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
        json!({
            "name": run.name,
            "values": values,
            "seed": run.case.preparation.seed,
            "settings": run.settings.iter().map(|(key, text)| (key.clone(), json!(text))).collect::<Map<_, _>>(),
            "case_digest": run.case.digest(),
        })
    };
    json!({
        "runs": planned.runs.iter().map(run).collect::<Vec<_>>(),
        "left_out_by_constraints": planned.left_out,
        "repeated": planned.repeated,
        "replaced_tests": plan.replaced_tests(planned),
    })
}
