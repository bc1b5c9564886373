//! Tables of rows for training.

use granum_core::digest::Digest;
use serde::{Deserialize, Serialize};

use crate::table::data_error::DataError;
use crate::table::sequences::Sequences;

/// Largest number of values in a table (inputs and targets together).
const LARGEST: usize = 1 << 28;

fn one() -> usize {
    1
}

/// Rows of inputs with their targets, both stored as flat arrays in row-major order.
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) sequences: Option<Sequences>,
    pub(crate) validation: Option<Box<Data>>,
}

impl Data {
    /// A table of `inputs.len() / input_columns` rows with one target each.
    ///
    /// # Errors
    /// If the lengths do not match, a value is not finite, or the table is empty.
    pub fn new(inputs: Vec<f64>, input_columns: usize, targets: Vec<f64>) -> Result<Data, DataError> {
        Data::with_target_columns(inputs, input_columns, targets, 1)
    }

    /// A table with several targets per row.
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
                "{} input values are not a whole number of rows of {input_columns} columns",
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
            sequences: None,
            validation,
        })
    }

    /// Groups so many consecutive rows into the points of one observation: the error of an observation is the difference
    /// between the mean of the network outputs for its rows and the mean of their targets. A network that receives a
    /// distribution point by point can thus learn a sum over the whole distribution (Zaheer et al. 2017) instead of
    /// predicting the target from every single point.
    ///
    /// Each observation counts as one; [`Data::with_observations`] must be called after this.
    ///
    /// # Errors
    /// If the rows do not form a whole number of observations, if they have more than one target or individual weights, or
    /// if validation rows have already been added.
    pub fn with_points(mut self, points: usize) -> Result<Data, DataError> {
        if points == 0 || !self.rows.is_multiple_of(points) {
            let rows = self.rows;
            return Err(DataError::Shape(format!(
                "{rows} rows are not a whole number of observations of {points} points"
            )));
        }
        if points > 1 && (self.target_columns > 1 || self.weights.is_some() || self.validation.is_some()) {
            return Err(DataError::Shape(
                "observations of several points need one target column and points without weights; add validation rows \
                 afterwards"
                    .into(),
            ));
        }
        self.points = points;
        self.blocks.clear();
        self.observations = (self.rows / points) as f64;
        self.weights = (points > 1).then(|| vec![1.0 / points as f64; self.rows]);
        Ok(self)
    }

    /// Sets a weight for each row, by which its squared error is multiplied. The weights are scaled to a mean of one.
    ///
    /// # Errors
    /// If the number of weights is not that of the rows, a weight is negative or not finite, or all are zero.
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
            return Err(DataError::Shape(
                "the points of an observation cannot have individual weights".into(),
            ));
        }
        let mean = weights.iter().sum::<f64>() / self.rows as f64;
        if mean == 0.0 {
            return Err(DataError::Weight { row: 0, value: 0.0 });
        }
        self.weights = Some(weights.into_iter().map(|w| w / mean).collect());
        self.observations = self.rows as f64;
        Ok(self)
    }

    /// Divides the rows into consecutive sequences, for models with memory.
    ///
    /// # Errors
    /// If the lengths of the sequences do not add up to the number of rows, or if rows form observations of several points.
    pub fn with_sequences(mut self, sequences: Sequences) -> Result<Data, DataError> {
        if sequences.rows() != self.rows {
            return Err(DataError::Shape(format!(
                "the sequences have {} rows together, the table has {}",
                sequences.rows(),
                self.rows
            )));
        }
        if self.points > 1 {
            return Err(DataError::Shape("observations of several points do not form sequences".into()));
        }
        self.sequences = Some(sequences);
        Ok(self)
    }

    /// The sequences of rows; `None` for rows without an order.
    pub fn sequences(&self) -> Option<&Sequences> {
        self.sequences.as_ref()
    }

    /// Number of rows of each observation; one unless it was set.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Sets the effective number of independent observations. Rows with common noise, such as those of one state of a test,
    /// would otherwise count as independent evidence, and Bayesian regularisation would fit the noise. The weights are
    /// scaled so that their sum is this number; the mean squared error does not change.
    ///
    /// # Errors
    /// If the number is not positive and finite.
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

    /// Sets the number of the block (the run or sample) to which each observation belongs (see [`Data::with_points`] for
    /// observations). The errors within a block are correlated, so that the error for a new block is estimated by leaving
    /// out each block in turn, see [`crate::Intervals`]. The training itself does not change.
    ///
    /// # Errors
    /// If there is not exactly one number for each observation.
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

    /// Sets the input column, from 0, as a function of which the scatter between blocks is estimated.
    ///
    /// # Errors
    /// If the column does not exist.
    pub fn with_spread_column(mut self, column: usize) -> Result<Data, DataError> {
        if column >= self.input_columns {
            let columns = self.input_columns;
            return Err(DataError::Shape(format!("there is no input column {column} of {columns}, from 0")));
        }
        self.spread_column = Some(column);
        Ok(self)
    }

    /// Adds validation rows, which are not used for training: training stops early when the error on them has not fallen for
    /// [`crate::trainer::Options::maximum_failures`] accepted steps in a row, and the weights with the smallest validation
    /// error are returned.
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
        if rows.sequences.is_some() != self.sequences.is_some() {
            let text = "validation rows and training rows must both be sequences, or neither";
            return Err(DataError::Shape(text.into()));
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

    /// Effective number of independent observations; the number of observations unless it was set.
    pub fn observations(&self) -> f64 {
        self.observations
    }

    /// Weight of each row, if weights were set; their sum is [`Data::observations`].
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// Number of the block of each observation; empty if blocks were not set.
    pub fn blocks(&self) -> &[usize] {
        &self.blocks
    }

    /// Number of blocks; 0 if blocks were not set.
    pub fn block_count(&self) -> usize {
        self.blocks.iter().collect::<std::collections::BTreeSet<_>>().len()
    }

    /// Weight of each observation, the sum of the weights of its rows.
    pub(crate) fn observation_weights(&self) -> Vec<f64> {
        match &self.weights {
            Some(weights) => weights.chunks(self.points).map(|points| points.iter().sum()).collect(),
            None => vec![1.0; self.rows / self.points],
        }
    }

    /// The validation rows for early stopping, if there are any.
    pub fn validation(&self) -> Option<&Data> {
        self.validation.as_deref()
    }

    /// SHA-256 of all bits of the table (inputs, targets, weights and validation rows), which identifies the data in a
    /// record.
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
        // Rows without sequences keep the digest that they had before there were sequences.
        if let Some(sequences) = &self.sequences {
            sequences.feed(digest);
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
        let cut =
            |lengths: Vec<usize>| data(2.0).with_sequences(Sequences::new(lengths).unwrap()).unwrap().hash();
        assert_ne!(data(2.0).hash(), cut(vec![2]));
        assert_ne!(cut(vec![1, 1]), cut(vec![2]));
    }
}
