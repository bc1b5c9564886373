//! `granum table`: runs side by side, a row for each.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use granum_core::Column;
use granum_io::shell::ShowPath;
use granum_io::{RunStatus, check_output_file, write_table};
use granum_run::runs_table::{RunEntry, RunsTable, Selection};
use granum_run::strength::{SECANT_REMARK, is_cohesive};
use serde_json::{Map, Value, json};

use super::run_folders::run_entries;
use super::text_table;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Make a table of runs, a row for each: every key by which their cases differ, the sample, the strength, the checks, the digests.
///
/// The keys are the resolved ones of the case files, stages (stage.1.lateral_stress) and materials included; numbers are in SI units,
/// angles in degrees. On the terminal the main columns are shown; a file, --all and --json have all of them. A number that a run
/// does not have is an empty cell (in Parquet NaN).
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum table study\n  granum table study -o study.csv\n  granum table run-1 run-2 other/study -o all.parquet"
)]
pub struct Table {
    /// Folders of runs, campaigns, data sets, or folders that contain runs and are searched.
    #[arg(required = true, value_name = "RUN")]
    folders: Vec<PathBuf>,
    /// File to write (.csv or .parquet).
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Show all columns on the terminal.
    #[arg(long)]
    all: bool,
}

impl Table {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if let Some(path) = &self.output {
            check_output_file(path, context.force)?;
        }
        let reading = context.nothing_written(Some("reading the runs"));
        let all = self.output.is_some() || self.all || context.json;
        let mut runs = run_entries(context, &self.folders, all)?;
        drop(reading);
        // Runs of different studies may have the same name.
        let mut alike: BTreeMap<String, usize> = BTreeMap::new();
        runs.iter().for_each(|run| *alike.entry(run.name.clone()).or_default() += 1);
        for run in &mut runs {
            if alike.get(&run.name).is_some_and(|count| *count > 1) {
                run.name = run.folder.shown();
            }
        }
        for run in runs.iter().filter(|run| run.record.status != RunStatus::Finished) {
            context.warn(&format!("{} did not reach its end", run.name));
        }
        let is_cohesive = |run: &RunEntry| {
            run.record.measures.contains_key("peak_friction_angle") && is_cohesive(&run.case)
        };
        if runs.iter().any(is_cohesive) {
            context.note(SECANT_REMARK);
        }
        let table = RunsTable::from_runs(&runs);
        let full = table.select(Selection::All);
        if let Some(path) = &self.output {
            write_table(path, &full)?;
        }
        let shown = if self.all { full.clone() } else { table.select(Selection::Main) };
        output::say(context, &as_json(&full, self.output.as_ref()), || {
            let mut lines = text_table::lines(&shown);
            if let Some(path) = &self.output {
                let (rows, columns) = (full.rows(), full.columns().len());
                lines.push(format!("wrote {rows} rows with {columns} columns to {}", path.shown()));
            }
            lines.join("\n")
        })
    }
}

/// The columns with their units, and the runs as objects.
fn as_json(table: &granum_core::Table, output: Option<&PathBuf>) -> Value {
    let units: Map<String, Value> = (table.columns().iter())
        .filter(|column| !column.unit.is_empty())
        .map(|column| (column.name.clone(), json!(column.unit)))
        .collect();
    let row = |row: usize| {
        let value = |column: &Column| match column.numbers() {
            Some(values) => match values.get(row).filter(|value| value.is_finite()) {
                Some(whole) if whole.fract() == 0.0 && whole.abs() < 1e15 => json!(*whole as i64),
                value => json!(value),
            },
            None => json!(column.word(row)),
        };
        let cells = table.columns().iter().map(|column| (column.name.clone(), value(column)));
        Value::Object(cells.collect())
    };
    let runs: Vec<Value> = (0..table.rows()).map(row).collect();
    json!({ "runs": runs, "units": units, "output": output.map(|path| output::path(path)) })
}
