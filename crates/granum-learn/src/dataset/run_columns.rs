//! The columns that the record of a test gives: the series, one column for each bin of each histogram, the arc length of the path, and
//! the measures of the sample.

use granum_core::{Column, Table};
use granum_io::case::{CaseParameter, ParameterValue};
use granum_sensors::force_distribution::FORCES;
use granum_sensors::{Histograms, Record};

use super::column_group::ColumnGroup;
use super::keys::{STAGE, STATE};
use crate::error::{LearnError, Result};

/// Arc length of the strain path up to a state.
const ARC_LENGTH: &str = "arc_length";
/// Density in the bins of a histogram; by itself the density of the contact forces P(f).
const DENSITY: &str = "probability_density";
/// Beginning of the names of the measures of the sample.
const SAMPLE: &str = "sample";
/// Columns of a series that do not measure anything.
const NOT_MEASURED: [&str; 3] = [STAGE, STATE, "observations"];

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
        let lengths = if table.has(ARC_LENGTH) { None } else { arc_length(&table) };
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

/// The name of the columns of a histogram. That of the contact forces is P(f), the density without another word.
fn group_name(histogram: &str) -> String {
    if histogram == FORCES { DENSITY.into() } else { format!("{histogram}_{DENSITY}") }
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
    let group = ColumnGroup { name: group_name(&histograms.name), binned, bin_width, centres };
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

/// What the sensors measured on the sample, before it was strained: the columns of the state 0 of the first stage, as `sample.NAME`, and
/// the void ratio, which follows from the solid fraction. Nothing if that state was not recorded.
fn sample_measures(series: &Table) -> Vec<CaseParameter> {
    let first = |name: &str| series.values(name).and_then(|values| values.first()).copied();
    if first(STATE) != Some(0.0) || first(STAGE).is_some_and(|stage| stage != 1.0) {
        return Vec::new();
    }
    let parameter = |name: &str, unit: &str, value: f64| {
        CaseParameter::new(format!("{SAMPLE}.{name}"), unit, ParameterValue::Number(value))
    };
    let measured = series.columns().iter().filter(|column| !NOT_MEASURED.contains(&column.name.as_str()));
    let mut all: Vec<CaseParameter> = measured
        .filter_map(|column| {
            let value = column.numbers()?.first().filter(|value| value.is_finite())?;
            Some(parameter(&column.name, &column.unit, *value))
        })
        .collect();
    if let Some(solid) = first("solid_fraction").filter(|solid| !series.has("void_ratio") && *solid > 0.0) {
        all.push(parameter("void_ratio", "", (1.0 - solid) / solid));
    }
    all
}

/// The arc length of the strain path up to each state, from the strains along the axes at the recorded states.
fn arc_length(series: &Table) -> Option<Vec<f64>> {
    let strains: Vec<&[f64]> = ["axial_strain", "lateral_strain_2", "lateral_strain_3"]
        .iter()
        .map(|name| series.values(name))
        .collect::<Option<_>>()?;
    let mut length = 0.0;
    let step = |row: usize| {
        let square = |strain: &&[f64]| {
            let before = if row == 0 { 0.0 } else { strain[row - 1] };
            (strain[row] - before) * (strain[row] - before)
        };
        (2.0 / 3.0 * strains.iter().map(square).sum::<f64>()).sqrt()
    };
    Some(
        (0..series.rows())
            .map(|row| {
                length += step(row);
                length
            })
            .collect(),
    )
}
