//! The columns that the record of a test gives: the series, one column for each bin of each histogram, the arc length of the path, and
//! the measures of the sample.

use granum_core::{Column, Table};
use granum_io::case::CaseParameter;
use granum_run::derived_columns::{ARC_LENGTH, arc_length, density_name, sample_measures};
use granum_sensors::{Histograms, Record};

use super::column_group::ColumnGroup;
use crate::error::{LearnError, Result};

/// The error of a record that cannot be used.
pub fn record_error(run: &str, reason: impl Into<String>) -> LearnError {
    LearnError::Record { run: run.to_owned(), reason: reason.into() }
}

/// The table of the states of a run with its histograms, and the measures of its sample.
pub(super) struct RunColumns {
    pub table: Table,
    pub groups: Vec<ColumnGroup>,
    pub sample: Vec<CaseParameter>,
}

impl RunColumns {
    /// From the record of a test, whose series becomes the table.
    pub fn new(name: &str, record: Record) -> Result<RunColumns> {
        let Record { series: mut table, histograms } = record;
        let sample = sample_measures(&table);
        let lengths = arc_length(&table);
        let mut added: Vec<Column> =
            lengths.into_iter().map(|lengths| Column::new(ARC_LENGTH, "", lengths)).collect();
        let mut groups = Vec::new();
        for histograms in &histograms {
            if let Some((group, densities)) = densities(name, histograms, table.rows())? {
                groups.push(group);
                added.extend(densities);
            }
        }
        for column in added {
            table.set(column).map_err(|error| record_error(name, error.to_string()))?;
        }
        Ok(RunColumns { table, groups, sample })
    }
}

/// A histogram as columns; nothing if it has no state.
fn densities(name: &str, histograms: &Histograms, rows: usize) -> Result<Option<(ColumnGroup, Vec<Column>)>> {
    let states = &histograms.states;
    let Some(first) = states.first() else { return Ok(None) };
    let called = |reason: String| record_error(name, format!("histogram {}: {reason}", histograms.name));
    if states.len() != rows {
        return Err(called(format!("{rows} states have {} histograms", states.len())));
    }
    let centres: Vec<f64> = (0..first.bins()).map(|bin| first.centre(bin)).collect();
    for (k, other) in states.iter().enumerate() {
        let alike = other.bins() == centres.len()
            && (0..other.bins()).all(|bin| (other.centre(bin) - centres[bin]).abs() < 1e-6 * first.bin_width);
        if !alike || (other.bin_width - first.bin_width).abs() > 1e-9 * first.bin_width {
            let reason = "its histogram does not have the bins of the first state";
            return Err(called(format!(
                "state {k}: {reason}; record with bins of width {}",
                first.bin_width
            )));
        }
    }
    let (bin_width, binned) = (first.bin_width, histograms.quantity.clone());
    let group = ColumnGroup { name: density_name(&histograms.name), binned, bin_width, centres };
    // A density is per unit of what is counted.
    let unit = match histograms.unit.as_str() {
        "" => String::new(),
        unit => format!("1/{unit}"),
    };
    let column = |(bin, name): (usize, String)| {
        Column::new(name, &unit, states.iter().map(|histogram| histogram.density(bin)).collect())
    };
    let columns = group.columns().enumerate().map(column).collect();
    Ok(Some((group, columns)))
}
