//! The division of rows into consecutive sequences of any length, for models with memory.

use std::ops::Range;

use granum_core::digest::Digest;
use serde::{Deserialize, Serialize};

use crate::table::data_error::DataError;

/// Consecutive sequences of rows, such as the states of whole runs, and the vectors from which a model with memory makes its
/// state before the first row of each.
///
/// ```
/// use granum_nets::Sequences;
///
/// // Two tests with three and two states; each starts from a sample with its own void ratio.
/// let sequences = Sequences::new(vec![3, 2])?.with_starts(vec![0.65, 0.72], 1)?;
/// assert_eq!((sequences.len(), sequences.rows()), (2, 5));
/// assert_eq!(sequences.ranges(), [0..3, 3..5]);
/// # Ok::<(), granum_nets::DataError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sequences {
    lengths: Vec<usize>,
    start_columns: usize,
    starts: Vec<f64>,
}

impl Sequences {
    /// Sequences with the given numbers of rows, without start vectors.
    ///
    /// # Errors
    /// If there is no sequence, or a sequence has no row.
    pub fn new(lengths: Vec<usize>) -> Result<Sequences, DataError> {
        if lengths.is_empty() || lengths.contains(&0) {
            return Err(DataError::Shape("there must be a sequence, and each needs at least one row".into()));
        }
        Ok(Sequences { lengths, start_columns: 0, starts: Vec::new() })
    }

    /// Sets the start vectors, `sequences x columns` values in row-major order.
    ///
    /// # Errors
    /// If there is not one vector for each sequence, or a value is not finite.
    pub fn with_starts(self, starts: Vec<f64>, columns: usize) -> Result<Sequences, DataError> {
        if starts.len() != self.lengths.len() * columns {
            return Err(DataError::Shape(format!(
                "{} sequences need {columns} start values each, not {} values",
                self.lengths.len(),
                starts.len()
            )));
        }
        if let Some(place) = starts.iter().position(|value| !value.is_finite()) {
            let (row, column) = (place / columns, place % columns);
            return Err(DataError::NotFinite { row, table: "start", column, value: starts[place] });
        }
        Ok(Sequences { start_columns: columns, starts, ..self })
    }

    /// Number of sequences.
    pub fn len(&self) -> usize {
        self.lengths.len()
    }

    /// False, since there is at least one sequence.
    pub fn is_empty(&self) -> bool {
        self.lengths.is_empty()
    }

    /// Number of rows of each sequence.
    pub fn lengths(&self) -> &[usize] {
        &self.lengths
    }

    /// Number of rows of all sequences.
    pub fn rows(&self) -> usize {
        self.lengths.iter().sum()
    }

    /// The rows of each sequence.
    pub fn ranges(&self) -> Vec<Range<usize>> {
        let mut first = 0;
        let range = |length: &usize| {
            first += length;
            first - length..first
        };
        self.lengths.iter().map(range).collect()
    }

    /// Number of values of a start vector; 0 if there are none.
    pub fn start_columns(&self) -> usize {
        self.start_columns
    }

    /// The start vectors in row-major order.
    pub fn starts(&self) -> &[f64] {
        &self.starts
    }

    /// The chosen sequences in the given order.
    pub(crate) fn chosen(&self, chosen: &[usize]) -> Sequences {
        let start = |&member: &usize| &self.starts[member * self.start_columns..][..self.start_columns];
        Sequences {
            lengths: chosen.iter().map(|&member| self.lengths[member]).collect(),
            start_columns: self.start_columns,
            starts: chosen.iter().flat_map(start).copied().collect(),
        }
    }

    pub(crate) fn feed(&self, digest: &mut Digest) {
        digest.text("sequences");
        digest.count(self.lengths.len());
        self.lengths.iter().for_each(|length| digest.count(*length));
        digest.count(self.start_columns);
        digest.numbers(&self.starts);
    }
}
