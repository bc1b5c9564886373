//! A campaign: how far it is, its runs, and the map of any key or measure against any other.

use std::collections::BTreeMap;

use granum_campaign::{Campaign, CampaignRun, CampaignStatus, RunState};
use granum_core::{Column, Table};
use granum_report::figure::marks::Shape;
use granum_report::figure::palette::{GREY, color};
use granum_report::figure::{Axis, Figure, Layer, Legend, Panel, Plot, literal};
use granum_run::runs_table::Selection;
use serde_json::{Map, Value, json};

use super::compare::columns;
use crate::answer::{Answer, Answered};
use crate::commands;
use crate::numbers::number;
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Rows of a table of runs.
const ROWS: (usize, usize) = (100, 1000);
/// Columns that are no quantity of a map.
const NO_QUANTITIES: [&str; 7] =
    ["name", "folder", "digest", "case_digest", "granum_version", "failed_checks", "checks"];
/// Most words of a column that are the names of an axis.
const MOST_WORDS: usize = 12;

fn opened(site: &Site, query: &Query) -> Result<Campaign, Refused> {
    let place = site.place(query.needed("path")?)?;
    let read = Campaign::read(&place, site.program.vocabulary());
    let found = read.map_err(|error| Refused::unreadable(site.without_root(error)))?;
    found.ok_or_else(|| Refused::not_found("there is no campaign"))
}

/// Its state: `path`, and `from` and `count` of its runs.
pub fn campaign(site: &Site, query: &Query) -> Answered {
    let campaign = opened(site, query)?;
    let path = query.needed("path")?;
    let status =
        CampaignStatus::read(&campaign).map_err(|error| Refused::unreadable(site.without_root(error)))?;
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    status.states.iter().for_each(|state| *counts.entry(state.word()).or_default() += 1);
    let from = query.count("from", 0)?;
    let count = query.count("count", ROWS.0)?.min(ROWS.1);
    let with_state = campaign.runs().iter().zip(&status.states).skip(from).take(count);
    let named = site.folder.as_named(path);
    let next = site.program.next(campaign.folder(), &named).unwrap_or_default();
    let mut lines = commands::of_campaign(&named);
    commands::add_next(&mut lines, next.command);
    Ok(Answer::Json(json!({
        "path": path,
        "at_work": status.at_work,
        "is_done": status.is_done(),
        "counts": counts,
        "total": campaign.runs().len(),
        "from": from,
        "variables": campaign.variables().iter().map(|variable| {
            json!({ "name": variable.name, "unit": variable.unit, "keys": variable.keys })
        }).collect::<Vec<_>>(),
        "runs": with_state.map(|(run, state)| row(site, &campaign, run, state)).collect::<Vec<_>>(),
        "plan": campaign.plan_text(),
        "next": site.without_root(next.text),
        "commands": lines,
    })))
}

fn row(site: &Site, campaign: &Campaign, run: &CampaignRun, state: &RunState) -> Value {
    let values: Map<String, Value> = campaign
        .variables()
        .iter()
        .zip(&run.values)
        .map(|(variable, value)| (variable.name.clone(), json!(value)))
        .collect();
    let reason = match state {
        RunState::Failed { reason } => site.without_root(reason),
        RunState::Finished { flags, .. } => {
            flags.iter().map(|flag| flag.name.as_str()).collect::<Vec<_>>().join(", ")
        }
        _ => String::new(),
    };
    json!({
        "name": run.name, "path": path_of(site, campaign, &run.name), "state": state.word(), "values": values, "reason": reason,
    })
}

/// The path of a run whose folder is there.
fn path_of(site: &Site, campaign: &Campaign, name: &str) -> Option<String> {
    let folder = campaign.folder_of(name);
    if folder.join("run.json").is_file() { site.folder.inside(&folder) } else { None }
}

/// The table of the runs that have been begun, with the values of the variables under their names.
fn table(site: &Site, campaign: &Campaign) -> Result<Table, Refused> {
    if campaign.runs().iter().all(|run| !campaign.folder_of(&run.name).join("run.json").is_file())
        && !CampaignStatus::read(campaign).is_ok_and(|status| status.count("finished") > 0)
    {
        return Ok(Table::default());
    }
    Ok(site.table(campaign.folder())?.select(Selection::All))
}

/// The columns that a map can show: numbers, and words of which there are few.
fn quantities(table: &Table) -> Vec<Value> {
    let usable = |column: &&Column| {
        let is_known = match column.numbers() {
            Some(numbers) => numbers.iter().any(|value| value.is_finite()),
            None => words(column, table.rows()).len() <= MOST_WORDS,
        };
        is_known && !NO_QUANTITIES.contains(&column.name.as_str())
    };
    let told = |column: &Column| {
        // A key has a dot, a measure none.
        let kind = if column.name.contains('.') { "key" } else { "measure" };
        json!({ "name": column.name, "unit": column.unit, "is_number": column.numbers().is_some(), "kind": kind })
    };
    table.columns().iter().filter(usable).map(told).collect()
}

fn words(column: &Column, rows: usize) -> Vec<String> {
    let mut words: Vec<String> = (0..rows).filter_map(|row| column.word(row)).map(str::to_string).collect();
    words.sort();
    words.dedup();
    words
}

/// What a map can show: `path`. All runs are read for it, which takes a while where there are thousands.
pub fn map_quantities(site: &Site, query: &Query) -> Answered {
    let campaign = opened(site, query)?;
    Ok(Answer::Json(json!({ "quantities": quantities(&table(site, &campaign)?) })))
}

/// A map: `x` and `y` are columns of the table of runs; each point is a run.
pub fn map(site: &Site, query: &Query) -> Answered {
    let campaign = opened(site, query)?;
    let table = table(site, &campaign)?;
    let [x, y] = ["x", "y"].map(|axis| -> Result<(&Column, Axis, Vec<f64>), Refused> {
        let name = query.needed(axis)?;
        let column = table.get(name).filter(|_| !NO_QUANTITIES.contains(&name));
        let column = column.ok_or_else(|| Refused::not_found(format!("the runs have no {name:?}")))?;
        Ok(on_axis(column, table.rows()))
    });
    let ((x, x_axis, xs), (y, y_axis, ys)) = (x?, y?);
    let names: Vec<String> = (0..table.rows())
        .map(|row| table.get("name").and_then(|names| names.word(row)).unwrap_or("").into())
        .collect();
    let failed = table.values("checks_failed").unwrap_or(&[]);
    let is_flagged = |row: usize| failed.get(row).is_some_and(|count| *count > 0.0);
    let points: Vec<[f64; 2]> = xs.iter().zip(&ys).map(|(x, y)| [*x, *y]).collect();
    let of = |flagged: bool| -> Vec<[f64; 2]> {
        (0..points.len()).filter(|row| is_flagged(*row) == flagged).map(|row| points[row]).collect()
    };
    let plot = Plot::new(x_axis, y_axis)
        .with(Layer::dots(of(true), Shape::Square, 3.6, GREY))
        .with(Layer::dots(of(false), Shape::Circle, 3.6, color(0)));
    let description = format!("{} against {} of {} runs", plain(y), plain(x), points.len());
    let figure = Figure::new(&literal(&description), 1, vec![Panel::plot(plot)]).legend(Legend::Hidden);
    let places = figure.places(&points);
    let flagged = (0..points.len()).filter(|row| is_flagged(*row)).count();
    let point = |row: usize| {
        let [left, top] = places[row]?;
        Some(json!({
            "name": names[row], "path": path_of(site, &campaign, &names[row]), "x": number(points[row][0]), "y": number(points[row][1]),
            "left": left, "top": top, "flagged": is_flagged(row),
        }))
    };
    let shown =
        table.columns_where(|column| [&x.name, &y.name].contains(&&column.name) || column.name == "name");
    Ok(Answer::Json(json!({
        "svg": figure.to_svg(),
        "title": description,
        "caption": match flagged {
            0 => "Each mark is a run; it opens the run.".to_string(),
            _ => format!("Each mark is a run; it opens the run. Grey squares are {flagged} runs that did not pass a check."),
        },
        "points": (0..points.len()).filter_map(point).collect::<Vec<_>>(),
        "columns": columns(&shown),
    })))
}

/// A column on an axis: numbers as they are, words as the numbers of their names.
fn on_axis(column: &Column, rows: usize) -> (&Column, Axis, Vec<f64>) {
    let axis = Axis::new(&literal(&plain(column))).unit(&column.unit);
    match column.numbers() {
        Some(numbers) => (column, axis, numbers.to_vec()),
        None => {
            let names = words(column, rows);
            let place = |row: usize| {
                let word = column.word(row)?;
                names.iter().position(|name| name == word).map(|place| place as f64)
            };
            let values = (0..rows).map(|row| place(row).unwrap_or(f64::NAN)).collect();
            let shown: Vec<String> = names.iter().map(|name| literal(name)).collect();
            (column, axis.named(&shown), values)
        }
    }
}

/// The name of a column in words.
fn plain(column: &Column) -> String {
    column.name.replace('_', " ")
}
