//! The states of one run.

use std::borrow::Cow;
use std::sync::Arc;

use granum_core::digest::Digest;
use granum_core::names::suggestion;
use granum_core::quantity::format_number;
use granum_core::{Column, Table};
use granum_io::case::{CaseParameter, ParameterValue};
use granum_io::{Case, Run};
use granum_run::derived_columns::{listed, single_parameters};
use granum_run::record::read_record;
use granum_sensors::Record;

use super::category::Category;
use super::column_group::ColumnGroup;
use super::keys::{STAGE, STATE};
use super::run_columns::{RunColumns, record_error};
use super::variable::Variable;
use crate::error::{LearnError, Result};

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

/// The states of one run: a table with a row for each state, and parameters that are the same in all of them, numbers and words.
///
/// See [`super::Dataset`] for an example.
#[derive(Clone, Debug, PartialEq)]
pub struct RunStates {
    name: String,
    table: Table,
    groups: Arc<Vec<ColumnGroup>>,
    /// Numbers and words; lists have been taken apart. Parts of a run, which a split gives, share them.
    parameters: Arc<Vec<CaseParameter>>,
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
        let others = table.into_columns().into_iter();
        columns.extend(others.filter(|column| column.name != STAGE && column.name != STATE));
        let table = Table::new(columns).map_err(|error| record_error(name, error.to_string()))?;
        let run = RunStates { name: name.into(), table, groups: Arc::default(), parameters: Arc::default() };
        run.check_key()?;
        Ok(run)
    }

    /// A run from the measurements of a test: the columns of the series, one column for each bin of every histogram, the arc
    /// length of the strain path, the measures of the sample (`sample.solid_fraction`, every column of the state 0), and the seed of
    /// the sample as `preparation.seed`.
    ///
    /// For a test with stages the sensors provide the `arc_length`. For other tests it is summed over the recorded states
    /// from the strains along the axes.
    ///
    /// # Errors
    /// If there is not one histogram for each state, or if the bins differ between states.
    pub fn from_record(named: &NamedRecord) -> Result<RunStates> {
        let mut run = RunStates::of_record(named.name, named.record.clone())?;
        run.set_parameter(CaseParameter::new(
            granum_io::case::SEED,
            "",
            ParameterValue::Number(named.seed as f64),
        ));
        Ok(run)
    }

    /// As [`RunStates::from_record`], without the seed: the tables of the record become those of the run.
    ///
    /// # Errors
    /// As [`RunStates::from_record`].
    pub fn of_record(name: &str, record: Record) -> Result<RunStates> {
        let RunColumns { table, groups, sample } = RunColumns::new(name, record)?;
        let (groups, parameters) = (Arc::new(groups), Arc::new(sample));
        Ok(RunStates { groups, parameters, ..RunStates::new(name, table)? })
    }

    /// Reads the folder of a run, with every resolved key of its case as a parameter: numbers (`grains.material.friction`), words
    /// (`contact.normal`), and the numbers of lists one by one (`KEY.1`, `KEY.2`). Keys of unused parts of the case are left out.
    ///
    /// # Errors
    /// If the folder contains no record of a test, and as [`RunStates::from_record`].
    pub fn read(name: &str, run: &Run) -> Result<RunStates> {
        RunStates::of_case(name, &run.case()?, read_record(run)?)
    }

    /// From the case and the record of a run, as [`RunStates::read`] from its folder.
    ///
    /// # Errors
    /// As [`RunStates::from_record`].
    pub fn of_case(name: &str, case: &Case, record: Record) -> Result<RunStates> {
        let mut states = RunStates::of_record(name, record)?;
        single_parameters(case).into_iter().for_each(|found| states.set_parameter(found));
        Ok(states)
    }

    /// Adds a number as a parameter.
    ///
    /// # Errors
    /// If a column already has this name, or the value is not a finite number.
    pub fn with_parameter(mut self, name: &str, unit: &str, value: f64) -> Result<RunStates> {
        self.check_free(name)?;
        if !value.is_finite() {
            return Err(record_error(
                &self.name,
                format!("parameter {name} is {value}, not a finite number"),
            ));
        }
        self.set_parameter(CaseParameter::new(name, unit, ParameterValue::Number(value)));
        Ok(self)
    }

    /// Adds a column with a value of each state.
    ///
    /// # Errors
    /// If a column or parameter already has this name, or there is not one value for each state.
    pub fn with_column(mut self, name: &str, unit: &str, values: Vec<f64>) -> Result<RunStates> {
        if self.has(name) {
            return Err(record_error(&self.name, format!("it has {name} already")));
        }
        let mut columns = self.table.into_columns();
        columns.push(Column::new(name, unit, values));
        self.table = Table::new(columns).map_err(|error| record_error(&self.name, error.to_string()))?;
        Ok(self)
    }

    /// The same run with other values of a column or of a parameter, of which the first is taken.
    ///
    /// # Errors
    /// If there is none of this name, or not one value for each state.
    pub(crate) fn with_values(mut self, name: &str, values: Vec<f64>) -> Result<RunStates> {
        let variable = self.variable(name);
        let bad = |reason: String| record_error(&self.name, reason);
        let unit = variable.ok_or_else(|| bad(format!("it has no {name}")))?.unit;
        if self.table.has(name) {
            self.table.set(Column::new(name, unit, values)).map_err(|error| bad(error.to_string()))?;
        } else if let Some(value) = values.first() {
            self.set_parameter(CaseParameter::new(name, &unit, ParameterValue::Number(*value)));
        }
        Ok(self)
    }

    /// Adds a word as a parameter.
    ///
    /// # Errors
    /// If a column already has this name.
    pub fn with_word(mut self, name: &str, word: &str) -> Result<RunStates> {
        self.check_free(name)?;
        self.set_parameter(CaseParameter::new(name, "", ParameterValue::Word(word.into())));
        Ok(self)
    }

    fn check_free(&self, name: &str) -> Result<()> {
        match self.table.has(name) {
            true => Err(record_error(&self.name, format!("{name} is a column of its states already"))),
            false => Ok(()),
        }
    }

    /// Declares columns of the table to be a histogram, whose name then represents all of them.
    ///
    /// # Errors
    /// If a column of a bin is missing.
    pub fn with_group(mut self, group: ColumnGroup) -> Result<RunStates> {
        for column in group.columns() {
            self.column(&column)?;
        }
        let groups = Arc::make_mut(&mut self.groups);
        groups.retain(|known| known.name != group.name);
        groups.push(group);
        Ok(self)
    }

    fn set_parameter(&mut self, parameter: CaseParameter) {
        let parameters = Arc::make_mut(&mut self.parameters);
        parameters.retain(|known| known.key != parameter.key);
        parameters.push(parameter);
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

    /// The parameters of the run, numbers and words.
    pub fn parameters(&self) -> &[CaseParameter] {
        &self.parameters
    }

    fn find(&self, name: &str) -> Option<&CaseParameter> {
        self.parameters.iter().find(|known| known.key == name)
    }

    /// A parameter of the run that is a number.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.find(name).and_then(CaseParameter::number)
    }

    /// A parameter of the run as a word: its own, or the text of its number with the unit.
    pub fn word(&self, name: &str) -> Option<String> {
        let found = self.find(name)?;
        Some(match &found.value {
            ParameterValue::Word(word) => word.clone(),
            ParameterValue::Number(number) => {
                format!("{} {}", format_number(*number), found.unit).trim_end().to_string()
            }
            ParameterValue::List(numbers) => listed(numbers),
        })
    }

    /// Names and units of all columns of numbers, including parameters.
    pub fn variables(&self) -> Vec<Variable> {
        let columns = self.table.columns().iter().filter(|column| !column.has_words());
        let columns = columns.map(|column| Variable { name: column.name.clone(), unit: column.unit.clone() });
        let numbers = self.parameters.iter().filter(|found| found.number().is_some());
        let numbers = numbers.map(|found| Variable { name: found.key.clone(), unit: found.unit.clone() });
        columns.chain(numbers).collect()
    }

    /// The name and unit of a column of numbers: of the table, a parameter, or a word of a category (`contact.normal=hertz`). The bin
    /// of a histogram may be given with its centre in other digits.
    pub fn variable(&self, name: &str) -> Option<Variable> {
        let named = |name: &str, unit: &str| Variable { name: name.into(), unit: unit.into() };
        if let Some(column) = self.table.get(name).filter(|column| !column.has_words()) {
            return Some(named(name, &column.unit));
        }
        if let Some(found) = self.find(name).filter(|found| found.number().is_some()) {
            return Some(named(name, &found.unit));
        }
        if let Some(column) = self.bin_meant(name) {
            return Some(named(&column.name, &column.unit));
        }
        let (category, _) = Category::parts(name)?;
        self.find(category).map(|_| named(name, ""))
    }

    /// The column of the bin that a name means.
    fn bin_meant(&self, name: &str) -> Option<&Column> {
        let meant = self.groups.iter().find_map(|group| group.column_meant(name))?;
        self.table.get(&meant)
    }

    /// True if there is a column or parameter of numbers of the given name.
    pub fn has(&self, name: &str) -> bool {
        self.variable(name).is_some()
    }

    /// The values of a column, or of a parameter for every state.
    ///
    /// # Errors
    /// If there is none of the given name; the message suggests another name. If it is a word.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        Ok(self.values(name)?.into_owned())
    }

    /// As [`RunStates::column`], without a copy of what the table has.
    ///
    /// # Errors
    /// As [`RunStates::column`].
    pub fn values(&self, name: &str) -> Result<Cow<'_, [f64]>> {
        if let Some(values) = self.table.values(name) {
            return Ok(Cow::Borrowed(values));
        }
        if let Some(value) = self.parameter(name) {
            return Ok(Cow::Owned(vec![value; self.rows()]));
        }
        if let Some(column) = self.bin_meant(name) {
            return Ok(Cow::Borrowed(&column.values));
        }
        if let Some((category, word)) = Category::parts(name)
            && let Some(own) = self.word(category)
        {
            return Ok(Cow::Owned(vec![f64::from(u8::from(own == word)); self.rows()]));
        }
        if let Some(word) = self.word(name) {
            return Err(record_error(&self.name, format!("{name} is {word}, a word and not a number")));
        }
        let variables = self.variables();
        let names = variables.iter().map(|variable| variable.name.as_str());
        Err(record_error(&self.name, format!("there is no column {name}; {}", suggestion(name, names))))
    }

    /// The states for which `keep` is true.
    pub(super) fn select(&self, keep: impl Fn(usize) -> bool) -> RunStates {
        let rows: Vec<usize> = (0..self.rows()).filter(|&row| keep(row)).collect();
        RunStates {
            name: self.name.clone(),
            table: self.table.rows_at(&rows),
            groups: self.groups.clone(),
            parameters: self.parameters.clone(),
        }
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
        let (stages, states) = (self.values(STAGE)?, self.values(STATE)?);
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
            column.words.iter().for_each(|word| digest.text(word));
        }
        for found in self.parameters.iter() {
            digest.text(&found.key);
            digest.text(&found.unit);
            match &found.value {
                ParameterValue::Number(number) => digest.numbers(&[*number]),
                ParameterValue::Word(word) => digest.text(word),
                ParameterValue::List(numbers) => digest.numbers(numbers),
            }
        }
    }
}
