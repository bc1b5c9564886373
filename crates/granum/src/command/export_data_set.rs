//! `granum export` of a campaign or its data set: runs or states as one table, or the layout of another program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use granum_campaign::data_set::{
    BIN_WIDTH, BINS, DataSet, FIRST_BIN, QUANTITY, RUN, VARIABLE, grainlearning, states_of,
};
use granum_core::{Column, Table};
use granum_io::formats::hdf5;
use granum_io::formats::parquet::{ListColumn, TableWithLists, write_with_lists};
use granum_io::shell::ShowPath;
use granum_io::{Run, check_output_file, write_table};
use granum_learn::dataset::ColumnGroup;
use granum_run::derived_columns::{density_name, histogram_of_density};
use granum_run::record::read_record;

use crate::context::Context;
use crate::failure::Failure;

/// The table of states, with the histograms as lists or a column for each bin.
pub const STATES: &str = "states";
/// The table of runs.
const RUNS: &str = "runs";
/// The name of the layout.
pub const GRAINLEARNING: &str = "grainlearning";

/// Writes a table of a data set; returns what was written, in words.
pub fn write(
    context: &Context,
    folder: &Path,
    table: Option<&str>,
    output: &Path,
) -> Result<String, Failure> {
    check_output_file(output, context.force)?;
    let data_set = DataSet::read(folder, context.reading())?;
    match table.unwrap_or(STATES) {
        RUNS => {
            write_table(output, &data_set.runs)?;
            Ok(format!("{} rows of runs", data_set.runs.rows()))
        }
        STATES => {
            let whole = with_variables(&data_set)?;
            let rows = whole.table.rows();
            let groups = whole.lists.iter().map(|list| group(&data_set.runs, &list.name)).collect::<Vec<_>>();
            write_states(context, output, whole, &groups)?;
            Ok(format!("{rows} rows of states"))
        }
        other => Err(Failure::new(format!("--table {other:?}: a data set has the tables states and runs"))),
    }
}

/// Writes the states of one run in the same form.
pub fn write_run(context: &Context, run: &Run, output: &Path) -> Result<String, Failure> {
    let record = read_record(run)?;
    let whole = states_of(None, &record)?;
    let rows = whole.table.rows();
    let groups = record.histograms.iter().map(|histograms| {
        let first = histograms.states.first()?;
        let centres = (0..first.bins()).map(|bin| first.centre(bin)).collect();
        let name = density_name(&histograms.name);
        Some(ColumnGroup { name, binned: histograms.quantity.clone(), bin_width: first.bin_width, centres })
    });
    write_states(context, output, whole, &groups.collect::<Vec<_>>())?;
    Ok(format!("{rows} rows of states"))
}

/// The states with the variables of their runs beside the name of the run.
fn with_variables(data_set: &DataSet) -> Result<TableWithLists, Failure> {
    let states = &data_set.states;
    let names = data_set.runs.get(RUN).ok_or_else(|| Failure::new("the data set has no column run"))?;
    let places: BTreeMap<&str, usize> =
        (0..data_set.runs.rows()).filter_map(|row| Some((names.word(row)?, row))).collect();
    let own = states.table.get(RUN).ok_or_else(|| Failure::new("the states have no column run"))?;
    let rows: Vec<usize> = (0..states.table.rows())
        .map(|row| own.word(row).and_then(|name| places.get(name)).copied())
        .collect::<Option<_>>()
        .ok_or_else(|| Failure::new("the states are not those of the runs"))?;
    let variables = data_set.runs.columns_where(|column| column.name.starts_with(VARIABLE)).rows_at(&rows);
    let mut columns = states.table.columns().to_vec();
    columns.splice(1..1, variables.into_columns());
    Ok(TableWithLists { table: Table::new(columns)?, lists: states.lists.clone() })
}

/// Lists stay lists in Parquet; other formats get a column for each bin where all runs have the same bins.
fn write_states(
    context: &Context,
    output: &Path,
    whole: TableWithLists,
    groups: &[Option<ColumnGroup>],
) -> Result<(), Failure> {
    if output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet")) {
        return Ok(write_with_lists(output, &whole)?);
    }
    let mut columns = whole.table.into_columns();
    for (list, group) in whole.lists.iter().zip(groups) {
        match group.as_ref().and_then(|group| flattened(list, group)) {
            Some(bins) => columns.extend(bins),
            None => context.warn(&format!(
                "{} is left out: its bins are not the same in all runs; a Parquet file has it as lists",
                list.name
            )),
        }
    }
    Ok(write_table(output, &Table::new(columns)?)?)
}

/// A column for each bin; `None` if a state has other bins.
fn flattened(list: &ListColumn, group: &ColumnGroup) -> Option<Vec<Column>> {
    let bins = group.centres.len();
    if bins == 0 || list.lengths.iter().any(|length| *length != bins) {
        return None;
    }
    let column = |(bin, name): (usize, String)| {
        Column::new(name, &list.unit, list.values.iter().skip(bin).step_by(bins).copied().collect())
    };
    Some(group.columns().enumerate().map(column).collect())
}

/// The bins of a histogram; `None` if they differ between runs.
fn group(runs: &Table, name: &str) -> Option<ColumnGroup> {
    let histogram = histogram_of_density(name);
    let same = |end: &str| {
        let values = runs.values(&format!("{histogram}{end}"))?;
        values.first().copied().filter(|first| values.iter().all(|value| value == first))
    };
    let (bin_width, first) = (same(BIN_WIDTH)?, same(FIRST_BIN)?);
    let bins = same(BINS)?;
    let centres = (0..bins as usize).map(|bin| (first + bin as f64 + 0.5) * bin_width).collect();
    let binned = runs.get(&format!("{histogram}{QUANTITY}"))?.word(0)?.to_string();
    Some(ColumnGroup { name: name.to_string(), binned, bin_width, centres })
}

/// Writes a data set in the layout of GrainLearning; returns what was written, in words.
pub fn write_grainlearning(
    context: &Context,
    folder: &Path,
    length: Option<usize>,
    output: &Path,
) -> Result<String, Failure> {
    check_output_file(output, context.force)?;
    let data_set = DataSet::read(folder, context.reading())?;
    let made = grainlearning(&data_set, length)?;
    if !made.too_short.is_empty() {
        context.note(&format!(
            "{} runs have fewer than {} states and are left out: {}",
            made.too_short.len(),
            made.states,
            made.too_short.join(", ")
        ));
    }
    hdf5::write(output, &made.root)?;
    Ok(format!(
        "{} runs of {} states for GrainLearning (contact_params: {}; outputs: {})",
        made.runs,
        made.states,
        made.parameters.join(", "),
        made.outputs.join(", ")
    ))
}

/// The data set that is meant by the data of the command; `None` if these are something else.
pub fn data_set(data: &[PathBuf]) -> Result<Option<PathBuf>, Failure> {
    match data {
        [folder] if folder.is_dir() => Ok(DataSet::meant_by(folder)?),
        _ => Ok(None),
    }
}

/// The error of data that are no data set.
pub fn not_a_data_set(flag: &str, data: &[PathBuf]) -> Failure {
    let names: Vec<String> = data.iter().map(|path| path.shown()).collect();
    Failure::new(format!("{flag}: {} is neither a campaign nor its data set", names.join(", ")))
}
