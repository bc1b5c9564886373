//! The inputs of the states of whole runs, which surrogates predict.

use super::spec::Columns;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};

/// The inputs of the states of runs, one run after another: what a surrogate is asked. A method without memory predicts each
/// row on its own, and a method with memory needs to know where a run starts.
///
/// ```
/// use granum_learn::surrogate::RunInputs;
///
/// // Two runs with two and one states of two inputs.
/// let inputs = RunInputs::new(vec![0.0, 0.5, 0.1, 0.5, 0.0, 0.7], 2, vec![2, 1])?;
/// assert_eq!(inputs.rows().collect::<Vec<_>>(), [[0.0, 0.5], [0.1, 0.5], [0.0, 0.7]]);
/// assert_eq!(inputs.runs().nth(1), Some(&[0.0, 0.7][..]));
/// # Ok::<(), granum_learn::LearnError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RunInputs {
    values: Vec<f64>,
    columns: usize,
    lengths: Vec<usize>,
}

impl RunInputs {
    /// Rows in row-major order, which belong to consecutive runs with the given numbers of states.
    ///
    /// # Errors
    /// If there is no column, the values are not a whole number of rows, or the runs have another number of rows.
    pub fn new(values: Vec<f64>, columns: usize, lengths: Vec<usize>) -> Result<RunInputs> {
        if columns == 0 || !values.len().is_multiple_of(columns) {
            let count = values.len();
            return Err(LearnError::Rows(format!(
                "{count} values are not a whole number of rows of {columns}"
            )));
        }
        let (rows, all) = (values.len() / columns, lengths.iter().sum::<usize>());
        if rows != all || lengths.contains(&0) {
            return Err(LearnError::Rows(format!(
                "there are {rows} rows, and the runs have {all} together; each run needs at least one"
            )));
        }
        Ok(RunInputs { values, columns, lengths })
    }

    /// Rows without an order, each of which is the first state of a run of its own.
    ///
    /// # Errors
    /// As [`RunInputs::new`].
    pub fn separate(values: Vec<f64>, columns: usize) -> Result<RunInputs> {
        let rows = values.len() / columns.max(1);
        RunInputs::new(values, columns, vec![1; rows])
    }

    /// The inputs of a surrogate for all states of a data set.
    ///
    /// # Errors
    /// If a column is missing, a value is not finite, or a run has a word to which the surrogate was not fitted.
    pub fn from_dataset(dataset: &Dataset, columns: &Columns) -> Result<RunInputs> {
        let names = columns.input_names();
        dataset.check_words(&names)?;
        let lengths = dataset.runs().iter().map(RunStates::rows).collect();
        RunInputs::new(dataset.values(&names)?, names.len(), lengths)
    }

    /// All values in row-major order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of inputs.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of states of each run.
    pub fn lengths(&self) -> &[usize] {
        &self.lengths
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.values.len() / self.columns
    }

    /// True if there is no row.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The rows of all runs.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.columns)
    }

    /// The rows of each run in row-major order.
    pub fn runs(&self) -> impl Iterator<Item = &[f64]> {
        let mut rest = self.values.as_slice();
        self.lengths.iter().map(move |length| {
            let (run, others) = rest.split_at(length * self.columns);
            rest = others;
            run
        })
    }
}
