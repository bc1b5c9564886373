//! A data set: the states of its runs, by the names of their columns.

use std::collections::BTreeSet;

use granum_core::digest::Digest;
use granum_core::names::suggestion;
use granum_core::{Column, ColumnKind, Table};
use granum_io::Run;
use granum_io::shell::ShowPath;

use super::column_group::ColumnGroup;
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
        let mut names = BTreeSet::new();
        for run in &runs {
            if !names.insert(run.name()) {
                return bad(format!("two runs have the name {}; give each its own", run.name()));
            }
            if run.rows() == 0 {
                return bad(format!("run {} has no state", run.name()));
            }
        }
        Ok(Dataset { runs })
    }

    /// The data set of runs: their measurements, with every resolved key of their case files and the measures of their samples
    /// as parameters. The name of a run is its folder as it was opened; `Registry::run_at` opens one whose case names laws, paths or sensors
    /// of a program.
    ///
    /// # Errors
    /// If a run has no record of a test, and as [`Dataset::new`].
    pub fn read(runs: &[Run]) -> Result<Dataset> {
        let read = |run: &Run| RunStates::read(&run.path().shown(), run);
        Dataset::new(runs.iter().map(read).collect::<Result<_>>()?)
    }

    /// The runs.
    pub fn runs(&self) -> &[RunStates] {
        &self.runs
    }

    /// Number of rows of all runs.
    pub fn rows(&self) -> usize {
        self.runs.iter().map(RunStates::rows).sum()
    }

    /// The columns of numbers that all runs have, including parameters, in the order of the first run.
    pub fn variables(&self) -> Vec<Variable> {
        let Some((first, others)) = self.runs.split_first() else { return Vec::new() };
        let mut variables = first.variables();
        variables.retain(|variable| others.iter().all(|run| run.has(&variable.name)));
        variables
    }

    /// The column of numbers of the given name, with its unit.
    ///
    /// # Errors
    /// If a run lacks the column; the message names that run, or suggests another name. If it holds words.
    pub fn variable(&self, name: &str) -> Result<Variable> {
        if let Some(found) = self.runs.first().and_then(|run| run.variable(name))
            && self.runs.iter().all(|run| run.has(name))
        {
            return Ok(found);
        }
        if let Some(category) = self.category(name) {
            let words = category.list();
            return Err(LearnError::Dataset(format!(
                "{name} holds words ({words}), not numbers; it can be an input of surrogates and nothing else"
            )));
        }
        let has = |run: &&RunStates| run.has(name) || run.word(name).is_some();
        if self.runs.iter().any(|run| has(&run)) {
            let without: Vec<&str> = self.runs.iter().filter(|run| !has(run)).map(RunStates::name).collect();
            return Err(LearnError::Dataset(format!(
                "not all runs have a column {name}; it is missing in {}",
                without.join(", ")
            )));
        }
        let mut names: Vec<String> = self.variables().into_iter().map(|variable| variable.name).collect();
        names.extend(self.categories().into_iter().map(|category| category.name));
        names.extend(
            self.runs.first().into_iter().flat_map(RunStates::groups).map(|group| group.name.clone()),
        );
        let hint = suggestion(name, names.iter().map(String::as_str));
        Err(LearnError::Dataset(format!("there is no column {name}; {hint}")))
    }

    /// The values of a column, one run after another.
    ///
    /// # Errors
    /// As [`Dataset::variable`].
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        self.variable(name)?;
        let mut all = Vec::with_capacity(self.rows());
        for run in &self.runs {
            all.extend_from_slice(&run.values(name)?);
        }
        Ok(all)
    }

    /// The names of columns for a list in which the name of a histogram (`probability_density`) represents all of its bins, and
    /// that of a category (`contact.normal`) the columns of its words (`contact.normal=hertz`).
    ///
    /// # Errors
    /// As [`Dataset::variable`].
    pub fn expand<S: AsRef<str>>(&self, names: &[S]) -> Result<Vec<String>> {
        let mut all = Vec::new();
        for name in names.iter().map(AsRef::as_ref) {
            match (self.runs.first().and_then(|run| run.group(name)), self.category(name)) {
                (Some(group), _) => {
                    self.check_bins(group)?;
                    all.extend(group.columns());
                }
                (None, Some(category)) => all.extend(category.columns()),
                (None, None) => all.push(self.variable(name)?.name),
            }
        }
        Ok(all)
    }

    /// Refuses a histogram of the first run that another run does not have with the same bins.
    pub(super) fn check_bins(&self, group: &ColumnGroup) -> Result<()> {
        let alike =
            |run: &&RunStates| run.group(&group.name).is_some_and(|own| own.columns().eq(group.columns()));
        let other: Vec<&str> = self.runs.iter().filter(|run| !alike(run)).map(RunStates::name).collect();
        if other.is_empty() {
            return Ok(());
        }
        let (name, first) = (&group.name, self.runs.first().map_or("", RunStates::name));
        Err(LearnError::Dataset(format!(
            "{} do not have the bins of {name} that {first} has; leave {name} out, or record all runs with the same bins",
            other.join(", ")
        )))
    }

    /// The values of columns in row-major order, one run after another, in the form for the fit and the prediction of
    /// surrogates.
    ///
    /// # Errors
    /// As [`Dataset::variable`], and if a value is not a finite number; the message gives its position.
    pub fn values<S: AsRef<str>>(&self, names: &[S]) -> Result<Vec<f64>> {
        names.iter().try_for_each(|name| self.variable(name.as_ref()).map(drop))?;
        let mut all = Vec::with_capacity(self.rows() * names.len());
        for run in &self.runs {
            let columns = names.iter().map(|name| run.values(name.as_ref())).collect::<Result<Vec<_>>>()?;
            for row in 0..run.rows() {
                for (column, name) in columns.iter().zip(names) {
                    let value = column[row];
                    if !value.is_finite() {
                        return Err(
                            run.at(row, &format!("{} is {value}, not a finite number", name.as_ref()))
                        );
                    }
                    all.push(value);
                }
            }
        }
        Ok(all)
    }

    /// The number of the run of each row, from 0.
    pub fn run_of_rows(&self) -> Vec<usize> {
        let runs = self.runs.iter().enumerate();
        runs.flat_map(|(k, run)| std::iter::repeat_n(k, run.rows())).collect()
    }

    /// The rows for which `keep` is true, given the run and the number of the row in it; runs without such a row are
    /// omitted.
    pub fn select(&self, keep: impl Fn(&RunStates, usize) -> bool) -> Dataset {
        let chosen = self.runs.iter().map(|run| run.select(|row| keep(run, row)));
        Dataset { runs: chosen.filter(|run| run.rows() > 0).collect() }
    }

    /// The whole data set as one table of states: the number of the run (from 1) in the column `run`, the columns of numbers that all
    /// runs have, and their categories as columns of words.
    ///
    /// # Errors
    /// If a column that all runs have is called `run`.
    pub fn table(&self) -> Result<Table> {
        let of_rows = self.run_of_rows();
        let mut columns = vec![Column::new("run", "", of_rows.iter().map(|run| (run + 1) as f64).collect())];
        for variable in self.variables() {
            columns.push(Column::new(&variable.name, &variable.unit, self.column(&variable.name)?));
        }
        for category in self.categories() {
            let words = self.runs.iter().map(|run| run.word(&category.name).unwrap_or_default());
            let words: Vec<String> = words.collect();
            let of_row = of_rows.iter().map(|run| words[*run].as_str());
            columns.push(Column::of_words(&category.name, of_row));
        }
        Ok(Table::new(columns)?)
    }

    /// The runs as a table, a row for each: its name in the column `run`, its number of states, and every parameter that one of the runs
    /// has, as numbers (NaN for a run without it) or, where it is a word in some run, as words (empty for a run without it).
    ///
    /// # Errors
    /// If a parameter is called `run` or `states`.
    pub fn runs_table(&self) -> Result<Table> {
        let states = self.runs.iter().map(|run| run.rows() as f64).collect();
        let mut columns = vec![
            Column::of_words("run", self.runs.iter().map(RunStates::name)),
            Column::new("states", "", states).of_kind(ColumnKind::Integer),
        ];
        let mut seen = BTreeSet::new();
        for found in self.runs.iter().flat_map(RunStates::parameters) {
            if !seen.insert(found.key.as_str()) {
                continue;
            }
            let is_word =
                |run: &RunStates| run.word(&found.key).is_some() && run.parameter(&found.key).is_none();
            columns.push(match self.runs.iter().any(is_word) {
                true => {
                    let words = self.runs.iter().map(|run| run.word(&found.key).unwrap_or_default());
                    Column::of_words(&found.key, words)
                }
                false => {
                    let numbers = self.runs.iter().map(|run| run.parameter(&found.key).unwrap_or(f64::NAN));
                    Column::new(&found.key, &found.unit, numbers.collect())
                }
            });
        }
        Ok(Table::new(columns)?)
    }

    /// SHA-256 of the names, the units and the bits of all numbers.
    pub fn digest(&self) -> String {
        let mut digest = Digest::new();
        digest.text("granum data set 2");
        self.runs.iter().for_each(|run| run.feed(&mut digest));
        digest.finish()
    }
}
