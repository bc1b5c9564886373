//! Rows for training.

use granum_core::digest::Digest;
use serde::{Deserialize, Serialize};

/// Most numbers that a table may hold (inputs and targets together).
const LARGEST: usize = 1 << 28;

/// What is wrong with a table of rows.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DataError {
    /// The number of values is no multiple of the number of columns, or a count is zero or too large.
    #[error("{0}")]
    Shape(String),
    /// A value is not finite.
    #[error("row {row}, {table} column {column}: {value} is not a finite number")]
    NotFinite {
        /// Row, from 0.
        row: usize,
        /// `input`, `target` or `weight`.
        table: &'static str,
        /// Column, from 0.
        column: usize,
        /// The value.
        value: f64,
    },
    /// A row weight is negative, or all are zero.
    #[error("row {row}: the weight {value} is negative; weights must be zero or positive and not all zero")]
    Weight {
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// The number of independent observations makes no sense.
    #[error("{0} independent observations: a positive number is possible")]
    Observations(f64),
}

fn one() -> usize {
    1
}

/// Rows of inputs with their targets, each table flat and row by row.
///
/// ```
/// // Two rows of two inputs and one target, worth one independent observation together.
/// let data = granum_nets::Data::new(vec![0.0, 1.0, 0.5, 2.0], 2, vec![0.1, 0.2])?.with_observations(1.0)?;
/// assert_eq!((data.rows(), data.input_columns(), data.observations()), (2, 2, 1.0));
/// # Ok::<(), granum_nets::DataError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Data {
    pub(crate) rows: usize,
    pub(crate) input_columns: usize,
    pub(crate) target_columns: usize,
    pub(crate) inputs: Vec<f64>,
    pub(crate) targets: Vec<f64>,
    pub(crate) weights: Option<Vec<f64>>,
    #[serde(default = "one")]
    pub(crate) points: usize,
    pub(crate) observations: f64,
    #[serde(default)]
    pub(crate) blocks: Vec<usize>,
    #[serde(default)]
    pub(crate) spread_column: Option<usize>,
    pub(crate) validation: Option<Box<Data>>,
}

impl Data {
    /// A table of `inputs.len() / input_columns` rows with one target each.
    ///
    /// # Errors
    /// If the lengths do not fit, a value is not finite, or the table is empty.
    pub fn new(inputs: Vec<f64>, input_columns: usize, targets: Vec<f64>) -> Result<Data, DataError> {
        Data::with_target_columns(inputs, input_columns, targets, 1)
    }

    /// A table with several targets a row.
    ///
    /// # Errors
    /// As [`Data::new`].
    pub fn with_target_columns(
        inputs: Vec<f64>,
        input_columns: usize,
        targets: Vec<f64>,
        target_columns: usize,
    ) -> Result<Data, DataError> {
        if input_columns == 0 || target_columns == 0 {
            return Err(DataError::Shape(
                "a table needs at least one input column and one target column".into(),
            ));
        }
        let rows = inputs.len() / input_columns;
        if rows == 0 || inputs.len() != rows * input_columns {
            return Err(DataError::Shape(format!(
                "{} input values are no whole number of rows of {input_columns} columns",
                inputs.len()
            )));
        }
        if targets.len() != rows * target_columns {
            return Err(DataError::Shape(format!(
                "{rows} rows with {target_columns} targets need {} target values, not {}",
                rows * target_columns,
                targets.len()
            )));
        }
        if inputs.len() + targets.len() > LARGEST {
            return Err(DataError::Shape(format!("a table holds at most {LARGEST} values")));
        }
        all_finite("input", &inputs, input_columns)?;
        all_finite("target", &targets, target_columns)?;
        let observations = rows as f64;
        let (weights, validation, points) = (None, None, 1);
        Ok(Data {
            rows,
            input_columns,
            target_columns,
            inputs,
            targets,
            weights,
            points,
            observations,
            blocks: Vec::new(),
            spread_column: None,
            validation,
        })
    }

    /// The same rows, of which so many that follow each other are the points of one observation: what counts is how far the
    /// mean of the network's answers to them is from the mean of their targets. So a network that sees a distribution point
    /// by point learns a sum over the whole distribution (Zaheer et al. 2017), instead of guessing from every single point.
    ///
    /// Each observation counts as one; give [`Data::with_observations`] afterwards.
    ///
    /// # Errors
    /// If the rows are no whole number of observations, have more than one target or weights of their own, or if there are
    /// validation rows already.
    pub fn with_points(mut self, points: usize) -> Result<Data, DataError> {
        if points == 0 || !self.rows.is_multiple_of(points) {
            let rows = self.rows;
            return Err(DataError::Shape(format!(
                "{rows} rows are no whole number of observations of {points} points"
            )));
        }
        if points > 1 && (self.target_columns > 1 || self.weights.is_some() || self.validation.is_some()) {
            return Err(DataError::Shape(
                "observations of several points have one target column, and their points no weights of their own; add \
                 validation rows after them"
                    .into(),
            ));
        }
        self.points = points;
        self.blocks.clear();
        self.observations = (self.rows / points) as f64;
        self.weights = (points > 1).then(|| vec![1.0 / points as f64; self.rows]);
        Ok(self)
    }

    /// The same rows with a weight each: the squared error of a row counts that many times. They are scaled to a mean
    /// of one.
    ///
    /// # Errors
    /// If their number is not that of the rows, one is negative or not finite, or all are zero.
    pub fn with_weights(mut self, weights: Vec<f64>) -> Result<Data, DataError> {
        if weights.len() != self.rows {
            return Err(DataError::Shape(format!(
                "{} rows need as many weights, not {}",
                self.rows,
                weights.len()
            )));
        }
        all_finite("weight", &weights, 1)?;
        if let Some(row) = weights.iter().position(|&w| w < 0.0) {
            return Err(DataError::Weight { row, value: weights[row] });
        }
        if self.points > 1 {
            return Err(DataError::Shape("points of an observation have no weights of their own".into()));
        }
        let mean = weights.iter().sum::<f64>() / self.rows as f64;
        if mean == 0.0 {
            return Err(DataError::Weight { row: 0, value: 0.0 });
        }
        self.weights = Some(weights.into_iter().map(|w| w / mean).collect());
        self.observations = self.rows as f64;
        Ok(self)
    }

    /// Number of rows that make one observation: one, unless it was given.
    pub fn points(&self) -> usize {
        self.points
    }

    /// The same rows, said to be worth no more than so many independent observations: rows that share their noise, as
    /// those of one state of a test do, would else pass for as many witnesses, and Bayesian regularisation would take the
    /// noise for structure. Weights are scaled so that they sum to it; the mean squared error does not change.
    ///
    /// # Errors
    /// If it is not a positive number.
    pub fn with_observations(mut self, observations: f64) -> Result<Data, DataError> {
        if !(observations > 0.0 && observations.is_finite()) {
            return Err(DataError::Observations(observations));
        }
        let factor = observations / self.observations;
        let weights = self.weights.unwrap_or_else(|| vec![1.0; self.rows]);
        self.weights = Some(weights.into_iter().map(|w| w * factor).collect());
        self.observations = observations;
        Ok(self)
    }

    /// The same rows, with the number of the block (the run, the sample) that each observation belongs to, one an observation
    /// (see [`Data::with_points`]). Blocks share what makes them differ from each other, so how far a prediction for a new
    /// block may be off is learned by leaving each of them out, see [`crate::Intervals`]. What is trained does not change.
    ///
    /// # Errors
    /// If there is not one number an observation.
    pub fn with_blocks(mut self, blocks: Vec<usize>) -> Result<Data, DataError> {
        let observations = self.rows / self.points;
        if blocks.len() != observations {
            let found = blocks.len();
            return Err(DataError::Shape(format!(
                "{observations} observations need as many numbers of blocks, not {found}"
            )));
        }
        self.blocks = blocks;
        Ok(self)
    }

    /// The same rows, whose scatter between blocks is told apart by the values of this input column, from 0.
    ///
    /// # Errors
    /// If there is no such column.
    pub fn with_spread_column(mut self, column: usize) -> Result<Data, DataError> {
        if column >= self.input_columns {
            let columns = self.input_columns;
            return Err(DataError::Shape(format!("there is no input column {column} of {columns}, from 0")));
        }
        self.spread_column = Some(column);
        Ok(self)
    }

    /// Adds rows that are not trained on: training stops early when the error on them has risen
    /// [`crate::trainer::Options::maximum_failures`] times in a row, and keeps the weights that were best on them.
    ///
    /// # Errors
    /// If their columns differ from those of the training rows.
    pub fn with_validation(mut self, rows: Data) -> Result<Data, DataError> {
        if rows.points != self.points {
            return Err(DataError::Shape(format!(
                "validation rows come in observations of {} points, training rows of {}",
                rows.points, self.points
            )));
        }
        if (rows.input_columns, rows.target_columns) != (self.input_columns, self.target_columns) {
            return Err(DataError::Shape(format!(
                "validation rows have {} inputs and {} targets, training rows {} and {}",
                rows.input_columns, rows.target_columns, self.input_columns, self.target_columns
            )));
        }
        self.validation = Some(Box::new(Data { validation: None, ..rows }));
        Ok(self)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of input columns.
    pub fn input_columns(&self) -> usize {
        self.input_columns
    }

    /// Number of target columns.
    pub fn target_columns(&self) -> usize {
        self.target_columns
    }

    /// Inputs, `rows x input_columns`, row by row.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// Targets, `rows x target_columns`, row by row.
    pub fn targets(&self) -> &[f64] {
        &self.targets
    }

    /// How many independent observations the rows are worth: their number, unless it was given.
    pub fn observations(&self) -> f64 {
        self.observations
    }

    /// Weight of each row, if they were given: they sum to [`Data::observations`].
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Number of the block of each observation; empty if they were not given.
    pub fn blocks(&self) -> &[usize] {
        &self.blocks
    }

    /// How many blocks there are; 0 if they were not given.
    pub fn block_count(&self) -> usize {
        self.blocks.iter().collect::<std::collections::BTreeSet<_>>().len()
    }

    /// What each observation counts: the sum over the weights of its rows.
    pub(crate) fn observation_weights(&self) -> Vec<f64> {
        match &self.weights {
            Some(weights) => weights.chunks(self.points).map(|points| points.iter().sum()).collect(),
            None => vec![1.0; self.rows / self.points],
        }
    }

    /// The rows for early stopping, if they were given.
    pub fn validation(&self) -> Option<&Data> {
        self.validation.as_deref()
    }

    /// SHA-256 of every bit of the table (inputs, targets, weights and validation rows), to name the data in a record.
    pub fn hash(&self) -> String {
        let mut digest = Digest::new();
        self.feed(&mut digest);
        digest.finish()
    }

    fn feed(&self, digest: &mut Digest) {
        for count in [self.rows, self.input_columns, self.target_columns, self.points] {
            digest.count(count);
        }
        for values in [&self.inputs, &self.targets, self.weights.as_ref().unwrap_or(&Vec::new())] {
            digest.numbers(values);
        }
        digest.count(self.blocks.len());
        self.blocks.iter().for_each(|block| digest.count(*block));
        digest.count(self.spread_column.map_or(0, |column| column + 1));
        digest.count(usize::from(self.validation.is_some()));
        if let Some(validation) = &self.validation {
            validation.feed(digest);
        }
    }
}

fn all_finite(table: &'static str, values: &[f64], columns: usize) -> Result<(), DataError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => {
            Err(DataError::NotFinite { row: i / columns, table, column: i % columns, value: values[i] })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_is_no_table() {
        assert!(Data::new(vec![1.0; 5], 2, vec![0.0; 2]).is_err());
        assert!(Data::new(vec![], 2, vec![]).is_err());
        assert!(Data::new(vec![1.0; 4], 0, vec![0.0; 2]).is_err());
        assert!(Data::new(vec![1.0; 4], 2, vec![0.0; 3]).is_err());
        let error = Data::new(vec![1.0, 2.0, f64::NAN, 4.0], 2, vec![0.0; 2]).unwrap_err();
        assert_eq!(error.to_string(), "row 1, input column 0: NaN is not a finite number");
        let data = Data::new(vec![1.0; 4], 2, vec![0.0; 2]).unwrap();
        assert!(data.clone().with_weights(vec![1.0, -1.0]).is_err());
        assert!(data.clone().with_weights(vec![0.0, 0.0]).is_err());
        assert!(data.clone().with_validation(Data::new(vec![1.0], 1, vec![0.0]).unwrap()).is_err());
        let weighted = data.clone().with_weights(vec![1.0, 3.0]).unwrap();
        assert_eq!(weighted.weights(), Some(&[0.5, 1.5][..]));
        assert!(
            data.clone().with_observations(0.0).is_err() && data.clone().with_observations(f64::NAN).is_err()
        );
        assert_eq!(data.observations(), 2.0);
        let fewer = weighted.with_observations(1.0).unwrap();
        assert_eq!((fewer.weights(), fewer.observations()), (Some(&[0.25, 0.75][..]), 1.0));
    }

    #[test]
    fn the_hash_sees_every_value() {
        let data = |x| Data::new(vec![1.0, x], 1, vec![0.0; 2]).unwrap();
        assert_eq!(data(2.0).hash(), data(2.0).hash());
        assert_ne!(data(2.0).hash(), data(2.0f64.next_up()).hash());
        assert_ne!(data(2.0).hash(), data(2.0).with_weights(vec![1.0, 2.0]).unwrap().hash());
    }
}
