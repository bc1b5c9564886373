//! A data set: the states of its runs, by the names of their columns.

use std::path::Path;

use granum_core::digest::Digest;
use granum_core::names::suggestion;
use granum_core::{Column, Table};
use granum_io::Run;
use granum_io::shell::ShowPath;

use super::run_states::RunStates;
use super::variable::Variable;
use crate::error::{LearnError, Result};

/// Named columns over the states of runs.
///
/// ```
/// use granum_core::{Column, Table};
/// use granum_learn::dataset::{Dataset, RunStates, Split};
///
/// // Two runs that differ in a parameter, given as tables.
/// let run = |name: &str, friction: f64| {
///     let strain: Vec<f64> = (0..10).map(|k| 0.01 * k as f64).collect();
///     let ratio = strain.iter().map(|e| friction * (1.0 - (-50.0 * e).exp())).collect();
///     let table = Table::new(vec![Column::new("arc_length", "", strain), Column::new("stress_ratio", "", ratio)])?;
///     RunStates::new(name, table)?.with_parameter("friction", "", friction)
/// };
/// let dataset = Dataset::new(vec![run("loose", 0.3)?, run("dense", 0.5)?])?;
/// assert_eq!(dataset.rows(), 20);
/// assert_eq!(dataset.column("friction")?[9..11], [0.3, 0.5]);
/// // Every second state of "loose" is used for training, the others are held out, and "dense" is an unseen run.
/// let parts = dataset.split(&Split::default().unseen(["dense"]))?;
/// assert_eq!((parts.training.rows(), parts.held_out.rows(), parts.unseen.rows()), (5, 5, 10));
/// let error = dataset.column("stress_ration").unwrap_err().to_string();
/// assert_eq!(error, "data set: there is no column stress_ration; did you mean stress_ratio?");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    runs: Vec<RunStates>,
}

impl Dataset {
    /// A data set of runs.
    ///
    /// # Errors
    /// If there are no runs, two runs have the same name, or a run has no states.
    pub fn new(runs: Vec<RunStates>) -> Result<Dataset> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        if runs.is_empty() {
            return bad("there is no run".into());
        }
        for (k, run) in runs.iter().enumerate() {
            if runs[..k].iter().any(|other| other.name() == run.name()) {
                return bad(format!("two runs have the name {}; give each its own", run.name()));
            }
            if run.rows() == 0 {
                return bad(format!("run {} has no state", run.name()));
            }
        }
        Ok(Dataset { runs })
    }

    /// The data set of run folders: their measurements, with the numbers of their case files as parameters. The name of a
    /// run is that of its folder as given here.
    ///
    /// # Errors
    /// If a folder contains no record of a test, and as [`Dataset::new`].
    pub fn read<P: AsRef<Path>>(folders: &[P]) -> Result<Dataset> {
        let read = |folder: &P| {
            let folder = folder.as_ref();
            RunStates::read(&folder.shown(), &Run::at(folder)?)
        };
        Dataset::new(folders.iter().map(read).collect::<Result<_>>()?)
    }

    /// The runs.
    pub fn runs(&self) -> &[RunStates] {
        &self.runs
    }

    /// Number of rows of all runs.
    pub fn rows(&self) -> usize {
        self.runs.iter().map(RunStates::rows).sum()
    }

    /// The columns that all runs have, including parameters, in the order of the first run.
    pub fn variables(&self) -> Vec<Variable> {
        let Some((first, others)) = self.runs.split_first() else { return Vec::new() };
        let mut variables = first.variables();
        variables.retain(|variable| others.iter().all(|run| run.has(&variable.name)));
        variables
    }

    /// The column of the given name, with its unit.
    ///
    /// # Errors
    /// If a run lacks the column; the message names that run, or suggests another name.
    pub fn variable(&self, name: &str) -> Result<Variable> {
        let variables = self.variables();
        if let Some(found) = variables.iter().find(|variable| variable.name == name) {
            return Ok(found.clone());
        }
        if self.runs.iter().any(|run| run.has(name)) {
            let without: Vec<&str> =
                self.runs.iter().filter(|run| !run.has(name)).map(RunStates::name).collect();
            return Err(LearnError::Dataset(format!(
                "not all runs have a column {name}; it is missing in {}",
                without.join(", ")
            )));
        }
        let names = variables.iter().map(|variable| variable.name.as_str());
        Err(LearnError::Dataset(format!("there is no column {name}; {}", suggestion(name, names))))
    }

    /// The values of a column, one run after another.
    ///
    /// # Errors
    /// As [`Dataset::variable`].
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        self.variable(name)?;
        let columns = self.runs.iter().map(|run| run.column(name)).collect::<Result<Vec<_>>>()?;
        Ok(columns.concat())
    }

    /// The names of columns for a list in which the name of a histogram (`probability_density`) represents all of its bins.
    ///
    /// # Errors
    /// As [`Dataset::variable`].
    pub fn expand<S: AsRef<str>>(&self, names: &[S]) -> Result<Vec<String>> {
        let mut all = Vec::new();
        for name in names.iter().map(AsRef::as_ref) {
            match self.runs.first().and_then(|run| run.group(name)) {
                Some(group) => all.extend(group.columns()),
                None => all.push(self.variable(name)?.name),
            }
        }
        Ok(all)
    }

    /// The values of columns in row-major order, one run after another, in the form for the fit and the prediction of
    /// surrogates.
    ///
    /// # Errors
    /// As [`Dataset::variable`], and if a value is not a finite number; the message gives its position.
    pub fn values<S: AsRef<str>>(&self, names: &[S]) -> Result<Vec<f64>> {
        let columns = names.iter().map(|name| self.column(name.as_ref())).collect::<Result<Vec<_>>>()?;
        for (name, values) in names.iter().zip(&columns) {
            if let Some(row) = values.iter().position(|value| !value.is_finite()) {
                let value = values[row];
                let reason = format!("{} is {value}, not a finite number", name.as_ref());
                return Err(self.at(row, &reason));
            }
        }
        Ok((0..self.rows()).flat_map(|row| columns.iter().map(move |column| column[row])).collect())
    }

    /// The number of the run of each row, from 0.
    pub fn run_of_rows(&self) -> Vec<usize> {
        let runs = self.runs.iter().enumerate();
        runs.flat_map(|(k, run)| std::iter::repeat_n(k, run.rows())).collect()
    }

    /// An error in a row, with the key of the row.
    fn at(&self, row: usize, reason: &str) -> LearnError {
        let mut before = 0;
        for run in &self.runs {
            if row < before + run.rows() {
                return run.at(row - before, reason);
            }
            before += run.rows();
        }
        LearnError::Dataset(reason.to_string())
    }

    /// The rows for which `keep` is true, given the run and the number of the row in it; runs without such a row are
    /// omitted.
    pub fn select(&self, keep: impl Fn(&RunStates, usize) -> bool) -> Dataset {
        let chosen = self.runs.iter().map(|run| run.select(|row| keep(run, row)));
        Dataset { runs: chosen.filter(|run| run.rows() > 0).collect() }
    }

    /// The whole data set as one table, with the number of the run (from 1) as its first column.
    ///
    /// # Errors
    /// If a column that all runs have is called `run`.
    pub fn table(&self) -> Result<Table> {
        let runs = self.run_of_rows().iter().map(|run| (run + 1) as f64).collect();
        let mut columns = vec![Column::new("run", "", runs)];
        for variable in self.variables() {
            columns.push(Column::new(&variable.name, &variable.unit, self.column(&variable.name)?));
        }
        Ok(Table::new(columns)?)
    }

    /// SHA-256 of the names, the units and the bits of all numbers.
    pub fn digest(&self) -> String {
        let mut digest = Digest::new();
        digest.text("granum data set 1");
        self.runs.iter().for_each(|run| run.feed(&mut digest));
        digest.finish()
    }
}
