//! What the data set has of a run: cells of its row among the runs, and its rows among the states.

use granum_io::formats::parquet::{ListColumn, TableWithLists};
use granum_io::{Case, Column, ColumnKind, Result, Table};
use granum_run::derived_columns::{ARC_LENGTH, arc_length, density_name};
use granum_sensors::{Histograms, Record};

use super::layout::{COUNTED, RUN};
use crate::campaign::Campaign;
use crate::campaign_file::CampaignRun;
use crate::rows::{RowFiles, StoredRun, read_run};

/// The results of a finished run of a campaign with its case: from its folder if it is there, or from its rows.
///
/// # Errors
/// If neither can be read.
pub fn read_finished(campaign: &Campaign, rows: &RowFiles, run: &CampaignRun) -> Result<(Case, StoredRun)> {
    let case = campaign.case_of(run)?;
    let folder = campaign.folder_of(&run.name);
    let stored = match folder.join("run.json").is_file() {
        true => read_run(&folder, campaign.vocabulary())?,
        false => rows.run(&run.name)?,
    };
    Ok((case, stored))
}

/// The states of a run as the rows of a data set: the series with stage, state and arc length, and the histograms as lists.
///
/// # Errors
/// If the record has a column of the name of another one.
pub fn states_of(name: Option<&str>, measured: &Record) -> Result<TableWithLists> {
    let series = &measured.series;
    let rows = series.rows();
    let whole = |name: &str, usual: &dyn Fn(usize) -> f64| {
        let values = series.values(name).map_or_else(|| (0..rows).map(usual).collect(), <[f64]>::to_vec);
        Column::new(name, "", values).of_kind(ColumnKind::Integer)
    };
    let mut columns: Vec<Column> =
        name.map(|name| Column::of_words(RUN, std::iter::repeat_n(name, rows))).into_iter().collect();
    columns.extend([whole("stage", &|_| 1.0), whole("state", &|row| row as f64)]);
    let others = series.columns().iter().filter(|column| column.name != "stage" && column.name != "state");
    columns.extend(others.cloned());
    columns.extend(arc_length(series).map(|lengths| Column::new(ARC_LENGTH, "", lengths)));
    let mut lists = Vec::new();
    for histograms in measured.histograms.iter().filter(|histograms| histograms.states.len() == rows) {
        let counted = histograms.states.iter().map(|histogram| histogram.total() as f64).collect();
        let name = format!("{}{COUNTED}", histograms.name);
        columns.push(Column::new(name, "", counted).of_kind(ColumnKind::Integer));
        lists.push(densities(histograms));
    }
    Ok(TableWithLists { table: Table::new(columns)?, lists })
}

/// The densities in the bins of a histogram, a list for each state. A density is per unit of what is counted.
fn densities(histograms: &Histograms) -> ListColumn {
    let unit = match histograms.unit.as_str() {
        "" => String::new(),
        unit => format!("1/{unit}"),
    };
    let mut list = ListColumn::new(density_name(&histograms.name), unit);
    for histogram in &histograms.states {
        list.push((0..histogram.bins()).map(|bin| histogram.density(bin)));
    }
    list
}
