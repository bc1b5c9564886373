//! Writes the files of a data set.

use std::io::Write;
use std::path::Path;

use granum_core::parallel;
use granum_io::atomic::write_atomically;
use granum_io::formats::parquet::{TableWithLists, write_groups};
use granum_io::{Error, OutputFolder, Result, write_table};

use super::contents::Contents;
use super::known::{content_digest, sums_of_tables, sums_text};
use super::layout::{
    CARD, CASE_FILE, DATA_SET, LEFT_OUT_FILE, METADATA, RUN, RUNS_FILE, SECONDS_FILE, STATES_FILE, SUMS,
};
use super::run_rows::states_of;
use super::run_table::RowTable;
use super::state_rows::StateColumns;
use super::written::Written;
use super::{card, croissant};
use crate::campaign::Campaign;
use crate::rows::RowFiles;

/// Number of runs that are read at once.
const RUNS_AT_ONCE: usize = 64;
/// Number of states from which on a group of rows is full; it always ends with a run.
const ROWS_OF_GROUP: usize = 1 << 16;
/// Removes the data set of a campaign, of which no run is left.
pub(super) fn remove(campaign: &Campaign) -> Result<()> {
    let path = campaign.folder().join(DATA_SET);
    if !path.join(SUMS).is_file() && !path.join(RUNS_FILE).is_file() {
        return Ok(());
    }
    let folder = OutputFolder::open(&path)?;
    folder.clear(&[SUMS, RUNS_FILE, STATES_FILE, LEFT_OUT_FILE, CASE_FILE, CARD, METADATA, SECONDS_FILE])
}

/// Writes the data set of a campaign whose runs have been taken in; returns the SHA-256 over its content and its number of states.
pub(super) fn write(
    campaign: &Campaign,
    rows: &RowFiles,
    contents: &Contents,
    made_of: &str,
    go_on: &(dyn Fn() -> Result<()> + Sync),
) -> Result<(String, usize)> {
    campaign.refuse_link(DATA_SET)?;
    let folder = OutputFolder::open_or_create(campaign.folder().join(DATA_SET))?;
    // From here to the end the data set is not whole.
    folder.clear(&[SUMS])?;
    let mut runs = RowTable::default();
    let mut seconds = RowTable::default();
    let mut columns = StateColumns::default();
    let mut count = 0;
    let sensors = campaign.sensors();
    for numbers in contents.taken.chunks(RUNS_AT_ONCE) {
        go_on()?;
        let read = parallel::map(numbers.len(), 0, |k| {
            let run = &campaign.runs()[numbers[k]];
            let stored = rows.run(&run.name)?;
            let states = states_of(Some(&run.name), &stored.measured)?;
            Ok::<_, Error>((run, campaign.case_of(run)?, stored, states))
        })?;
        for (run, case, stored, states) in &read {
            runs.run(campaign, run, case, stored, sensors);
            seconds.seconds(&run.name, stored);
            columns.add(states);
            count += states.table.rows();
        }
    }
    let runs = runs.finish()?;
    write_states(&folder.file(STATES_FILE), campaign, rows, contents, &columns, go_on)?;
    write_table(folder.file(RUNS_FILE), &runs)?;
    write_table(folder.file(SECONDS_FILE), &seconds.finish()?)?;
    write_left_out(&folder, campaign, contents)?;
    write_text(&folder, CASE_FILE, &campaign.base().resolved_toml())?;
    let sums = sums_of_tables(folder.path())?;
    let digest = content_digest(&sums);
    let states = columns.empty()?;
    let written = Written {
        campaign,
        contents,
        runs: &runs,
        states: &states,
        rows: count,
        sums: &sums,
        digest: &digest,
    };
    write_text(&folder, CARD, &card::text(&written))?;
    write_text(&folder, METADATA, &croissant::text(&written))?;
    write_text(&folder, SUMS, &sums_text(folder.path(), made_of, &sums)?)?;
    Ok((digest, count))
}

fn write_text(folder: &OutputFolder, name: &str, text: &str) -> Result<()> {
    write_atomically(&folder.file(name), |file| file.write_all(text.as_bytes()))
}

/// The states of the runs, some runs at a time.
fn write_states(
    path: &Path,
    campaign: &Campaign,
    rows: &RowFiles,
    contents: &Contents,
    columns: &StateColumns,
    go_on: &(dyn Fn() -> Result<()> + Sync),
) -> Result<()> {
    let mut chunks = contents.taken.chunks(RUNS_AT_ONCE);
    let (mut waiting, mut ended): (Vec<TableWithLists>, bool) = (Vec::new(), false);
    let mut group = || -> Result<Option<TableWithLists>> {
        let full = |waiting: &[TableWithLists]| {
            let mut sum = 0;
            waiting.iter().position(|run| {
                sum += run.table.rows();
                sum >= ROWS_OF_GROUP
            })
        };
        loop {
            let count = match (full(&waiting), ended) {
                (Some(last), _) => last + 1,
                (None, true) => waiting.len(),
                (None, false) => {
                    go_on()?;
                    match chunks.next() {
                        None => ended = true,
                        Some(numbers) => waiting.extend(parallel::map(numbers.len(), 0, |k| {
                            let name = &campaign.runs()[numbers[k]].name;
                            states_of(Some(name), &rows.run(name)?.measured)
                        })?),
                    }
                    continue;
                }
            };
            let runs: Vec<TableWithLists> = waiting.drain(..count).collect();
            return if runs.is_empty() { Ok(None) } else { columns.below_each_other(&runs).map(Some) };
        }
    };
    write_groups(path, &columns.empty()?, &mut group)
}

/// The runs that are not part of it.
fn write_left_out(folder: &OutputFolder, campaign: &Campaign, contents: &Contents) -> Result<()> {
    folder.clear(&[LEFT_OUT_FILE])?;
    if contents.left_out.is_empty() {
        return Ok(());
    }
    let mut table = RowTable::default();
    for out in &contents.left_out {
        let run = &campaign.runs()[out.number];
        table.begin_row();
        table.word(RUN, &run.name);
        table.word("state", out.state);
        table.word("failed_checks", &out.checks.join(" "));
        table.variables(campaign, run);
    }
    write_table(folder.file(LEFT_OUT_FILE), &table.finish()?)
}
