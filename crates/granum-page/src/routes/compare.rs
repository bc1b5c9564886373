//! Several runs beside each other: the keys in which they differ, and their results.

use granum_core::Table;
use granum_run::runs_table::{RunEntry, RunsTable, Selection};
use serde_json::{Value, json};

use super::figures::places;
use crate::answer::{Answer, Answered};
use crate::commands;
use crate::numbers::number;
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// The table of runs: `path`, several times.
pub fn compare(site: &Site, query: &Query) -> Answered {
    let places = places(site, query)?;
    let entry = |place: &std::path::PathBuf| -> Result<RunEntry, Refused> {
        let run = site.program.run_at(place).map_err(Refused::unreadable)?;
        RunEntry::from_run(&run)
            .and_then(RunEntry::with_strength)
            .map_err(|error| Refused::unreadable(site.without_root(error)))
    };
    let entries: Vec<RunEntry> = places.iter().map(entry).collect::<Result<_, _>>()?;
    let named: Vec<std::path::PathBuf> = query.all("path").map(|path| site.folder.as_named(path)).collect();
    let table = RunsTable::from_runs(&entries).select(Selection::Main);
    Ok(Answer::Json(json!({
        "paths": query.all("path").collect::<Vec<_>>(),
        "columns": columns(&table),
        "commands": commands::of_several(&named),
    })))
}

/// The columns of a table, of numbers or of words, with their units.
pub(super) fn columns(table: &Table) -> Value {
    let column = |column: &granum_core::Column| {
        let values: Value = match column.numbers() {
            Some(numbers) => numbers.iter().map(|value| number(*value)).collect(),
            None => (0..table.rows()).map(|row| json!(column.word(row))).collect(),
        };
        json!({ "name": column.name, "unit": column.unit, "is_number": column.numbers().is_some(), "values": values })
    };
    table.columns().iter().map(column).collect()
}
