//! The states of one run.

use granum_core::digest::Digest;
use granum_core::names::suggestion;
use granum_core::{Column, Table};
use granum_io::case::CaseParameter;
use granum_io::{Case, Run};
use granum_run::record::read_record;
use granum_sensors::Record;

use super::variable::Variable;
use crate::error::{LearnError, Result};

/// The columns of the key.
pub(crate) const STAGE: &str = "stage";
/// See [`STAGE`].
pub(crate) const STATE: &str = "state";
/// Arc length of the strain path up to a state.
const ARC_LENGTH: &str = "arc_length";
/// The histogram of contact forces; its columns are named after the centres of its bins, e.g. `probability_density_0.125`.
pub(crate) const DENSITY: &str = "probability_density";

/// A record with its name and seed.
#[derive(Clone, Copy, Debug)]
pub struct NamedRecord<'a> {
    /// Name of the run, for messages and figures.
    pub name: &'a str,
    /// Seed of the sample.
    pub seed: u64,
    /// The measurements.
    pub record: &'a Record,
}

/// The columns of a histogram: one for each bin.
///
/// ```
/// use granum_core::{Column, Table};
/// use granum_learn::dataset::{ColumnGroup, RunStates};
///
/// let columns = ["probability_density_0.5", "probability_density_1.5"];
/// let table = Table::new(columns.iter().map(|name| Column::new(*name, "", vec![0.6, 0.7])).collect())?;
/// let centres = vec![0.5, 1.5];
/// let (name, binned) = ("probability_density".to_string(), "force".to_string());
/// let run = RunStates::new("run", table)?.with_group(ColumnGroup { name, binned, bin_width: 1.0, centres })?;
/// assert_eq!(run.group("probability_density").unwrap().columns().collect::<Vec<_>>(), columns);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnGroup {
    /// The quantity in the columns; the name of each column consists of it and the centre of the bin.
    pub name: String,
    /// The binned variable.
    pub binned: String,
    /// Width of a bin.
    pub bin_width: f64,
    /// Centre of each bin.
    pub centres: Vec<f64>,
}

impl ColumnGroup {
    /// Name of the column of a bin.
    pub fn column(&self, centre: f64) -> String {
        format!("{}_{centre}", self.name)
    }

    /// Names of all columns.
    pub fn columns(&self) -> impl Iterator<Item = String> + '_ {
        self.centres.iter().map(|&centre| self.column(centre))
    }
}

/// The states of one run: a table with a row for each state, and parameters that are the same in all of them.
///
/// See [`super::Dataset`] for an example.
#[derive(Clone, Debug, PartialEq)]
pub struct RunStates {
    name: String,
    table: Table,
    groups: Vec<ColumnGroup>,
    parameters: Vec<(Variable, f64)>,
}

impl RunStates {
    /// A run from any table with one row for each state. Without a column `stage` all states belong to stage 1, and
    /// without a column `state` they are numbered from 0.
    ///
    /// # Errors
    /// If the name is empty, or the numbers of stages and states are not increasing integers.
    pub fn new(name: &str, table: Table) -> Result<RunStates> {
        if name.is_empty() {
            return Err(LearnError::Dataset("a run has no name".into()));
        }
        let rows = table.rows();
        let mut columns = vec![
            Column::new(STAGE, "", table.values(STAGE).map_or(vec![1.0; rows], <[f64]>::to_vec)),
            Column::new(
                STATE,
                "",
                table.values(STATE).map_or_else(|| (0..rows).map(|k| k as f64).collect(), <[f64]>::to_vec),
            ),
        ];
        columns.extend(table.columns().iter().filter(|c| c.name != STAGE && c.name != STATE).cloned());
        let table = Table::new(columns).map_err(|error| record_error(name, error.to_string()))?;
        let run = RunStates { name: name.into(), table, groups: Vec::new(), parameters: Vec::new() };
        run.check_key()?;
        Ok(run)
    }

    /// A run from the measurements of a test: the columns of the series, one column for each bin of the histogram of
    /// forces, the arc length of the strain path, and the seed of the sample as `preparation.seed`.
    ///
    /// For a test with stages the sensors provide the `arc_length`. For other tests it is summed over the recorded states
    /// from the strains along the axes.
    ///
    /// # Errors
    /// If there is not one histogram for each state, or if the bins differ between states.
    pub fn from_record(named: &NamedRecord) -> Result<RunStates> {
        let mut run = RunStates::of_sensors(named.name, named.record)?;
        run.set_parameter(granum_io::case::SEED, "", named.seed as f64);
        Ok(run)
    }

    /// Reads the folder of a run, with all numbers of its case file as parameters (`grains.material.friction`). Parameters
    /// of unused parts of the case, and choices such as the names of contact laws, do not become columns.
    ///
    /// # Errors
    /// If the folder contains no record of a test, and as [`RunStates::from_record`].
    pub fn read(name: &str, run: &Run) -> Result<RunStates> {
        let mut states = RunStates::of_sensors(name, &read_record(run)?)?;
        for (variable, value) in numbers_of(&run.case()?) {
            states.set_parameter(&variable.name, &variable.unit, value);
        }
        Ok(states)
    }

    fn of_sensors(name: &str, record: &Record) -> Result<RunStates> {
        let (group, densities) = histogram(name, record)?;
        let mut table = record.series.clone();
        let arc_length = if table.has(ARC_LENGTH) { None } else { arc_length(&table) };
        let arc_length = arc_length.map(|values| Column::new(ARC_LENGTH, "", values));
        for column in arc_length.into_iter().chain(densities) {
            table.set(column).map_err(|error| record_error(name, error.to_string()))?;
        }
        Ok(RunStates { groups: group.into_iter().collect(), ..RunStates::new(name, table)? })
    }

    /// Adds a parameter.
    ///
    /// # Errors
    /// If a column already has this name, or the value is not a finite number.
    pub fn with_parameter(mut self, name: &str, unit: &str, value: f64) -> Result<RunStates> {
        if self.table.has(name) {
            return Err(record_error(&self.name, format!("{name} is a column of its states already")));
        }
        if !value.is_finite() {
            return Err(record_error(
                &self.name,
                format!("parameter {name} is {value}, not a finite number"),
            ));
        }
        self.set_parameter(name, unit, value);
        Ok(self)
    }

    /// Declares columns of the table to be a histogram, whose name then represents all of them.
    ///
    /// # Errors
    /// If a column of a bin is missing.
    pub fn with_group(mut self, group: ColumnGroup) -> Result<RunStates> {
        for column in group.columns() {
            self.column(&column)?;
        }
        self.groups.retain(|known| known.name != group.name);
        self.groups.push(group);
        Ok(self)
    }

    fn set_parameter(&mut self, name: &str, unit: &str, value: f64) {
        let variable = Variable { name: name.into(), unit: unit.into() };
        self.parameters.retain(|(known, _)| known.name != name);
        self.parameters.push((variable, value));
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of states.
    pub fn rows(&self) -> usize {
        self.table.rows()
    }

    /// The states, without the parameters.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The histograms.
    pub fn groups(&self) -> &[ColumnGroup] {
        &self.groups
    }

    /// The histogram of the given name, if the run has one.
    pub fn group(&self, name: &str) -> Option<&ColumnGroup> {
        self.groups.iter().find(|group| group.name == name)
    }

    /// A parameter of the run.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(variable, _)| variable.name == name).map(|(_, value)| *value)
    }

    /// Names and units of all columns, including parameters.
    pub fn variables(&self) -> Vec<Variable> {
        let of = |column: &Column| Variable { name: column.name.clone(), unit: column.unit.clone() };
        let columns = self.table.columns().iter().map(of);
        columns.chain(self.parameters.iter().map(|(variable, _)| variable.clone())).collect()
    }

    /// True if there is a column or parameter of the given name.
    pub fn has(&self, name: &str) -> bool {
        self.table.has(name) || self.parameter(name).is_some()
    }

    /// The values of a column, or of a parameter for every state.
    ///
    /// # Errors
    /// If there is none of the given name; the message suggests another name.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        if let Some(values) = self.table.values(name) {
            return Ok(values.to_vec());
        }
        if let Some(value) = self.parameter(name) {
            return Ok(vec![value; self.rows()]);
        }
        let variables = self.variables();
        let names = variables.iter().map(|variable| variable.name.as_str());
        Err(record_error(&self.name, format!("there is no column {name}; {}", suggestion(name, names))))
    }

    /// The states for which `keep` is true.
    pub(super) fn select(&self, keep: impl Fn(usize) -> bool) -> RunStates {
        let rows: Vec<usize> = (0..self.rows()).filter(|&row| keep(row)).collect();
        let of = |column: &Column| {
            let values = rows.iter().map(|&row| column.values[row]).collect();
            Column::new(&column.name, &column.unit, values)
        };
        // The names are those of a valid table, so that this cannot fail.
        let table = Table::new(self.table.columns().iter().map(of).collect()).unwrap_or_default();
        RunStates { table, ..self.clone() }
    }

    /// An error in a row, with the key of the row.
    pub(super) fn at(&self, row: usize, reason: &str) -> LearnError {
        let number = |name: &str| self.table.values(name).and_then(|values| values.get(row)).copied();
        let key = match (number(STAGE), number(STATE)) {
            (Some(1.0), Some(state)) => format!("state {state}"),
            (Some(stage), Some(state)) => format!("stage {stage}, state {state}"),
            _ => format!("row {row}"),
        };
        record_error(&self.name, format!("{key}: {reason}"))
    }

    fn check_key(&self) -> Result<()> {
        let (stages, states) = (self.column(STAGE)?, self.column(STATE)?);
        for row in 0..self.rows() {
            let key = [stages[row], states[row]];
            if key.iter().any(|x| !(*x >= 0.0 && x.fract() == 0.0 && *x <= 9e15)) {
                let reason = "stages and states are counted by whole numbers from 0";
                return Err(record_error(&self.name, format!("row {row}: {reason}, not {key:?}")));
            }
            if row > 0 && key <= [stages[row - 1], states[row - 1]] {
                let reason = "the key must increase from row to row: first the stage, then the state in it";
                return Err(self.at(row, reason));
            }
        }
        Ok(())
    }

    pub(super) fn feed(&self, digest: &mut Digest) {
        digest.text(&self.name);
        for column in self.table.columns() {
            digest.text(&column.name);
            digest.text(&column.unit);
            digest.numbers(&column.values);
        }
        for (variable, value) in &self.parameters {
            digest.text(&variable.name);
            digest.text(&variable.unit);
            digest.numbers(&[*value]);
        }
    }
}

/// The error of a record that cannot be used.
pub fn record_error(run: &str, reason: impl Into<String>) -> LearnError {
    LearnError::Record { run: run.to_owned(), reason: reason.into() }
}

/// The numerical values of a case with their keys, those of its materials and stages included.
fn numbers_of(case: &Case) -> Vec<(Variable, f64)> {
    let number = |found: CaseParameter| {
        let value = found.number()?;
        Some((Variable { name: found.key, unit: found.unit }, value))
    };
    case.parameters().into_iter().filter_map(number).collect()
}

/// The histograms of forces as columns.
fn histogram(name: &str, record: &Record) -> Result<(Option<ColumnGroup>, Vec<Column>)> {
    let (histograms, states) = (record.forces(), record.series.rows());
    if !histograms.is_empty() && histograms.len() != states {
        return Err(record_error(name, format!("{states} states have {} histograms", histograms.len())));
    }
    let Some(first) = histograms.first() else { return Ok((None, Vec::new())) };
    let centres: Vec<f64> = (0..first.bins()).map(|bin| first.centre(bin)).collect();
    for (k, other) in histograms.iter().enumerate() {
        let alike = other.bins() == centres.len()
            && (0..other.bins()).all(|bin| (other.centre(bin) - centres[bin]).abs() < 1e-6 * first.bin_width);
        if !alike || (other.bin_width - first.bin_width).abs() > 1e-9 * first.bin_width {
            let reason = "its histogram does not have the bins of the first state";
            return Err(record_error(
                name,
                format!("state {k}: {reason}; record with bins of width {}", first.bin_width),
            ));
        }
    }
    let bin_width = first.bin_width;
    let group = ColumnGroup { name: DENSITY.into(), binned: "force".into(), bin_width, centres };
    let column = |(bin, name): (usize, String)| {
        Column::new(name, "", histograms.iter().map(|histogram| histogram.density(bin)).collect())
    };
    let columns = group.columns().enumerate().map(column).collect();
    Ok((Some(group), columns))
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
