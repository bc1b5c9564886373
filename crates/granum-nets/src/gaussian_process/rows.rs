//! The inputs of the rows to which processes are fitted.

use granum_simd::{LANES, Row8};

use super::error::GaussianProcessError;

/// Rows of inputs in row-major order. The inputs should have a mean near zero and a standard deviation near one, since the prior of the
/// length scales counts in such units.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    values: Vec<f64>,
    columns: usize,
}

impl Rows {
    /// Rows of the given number of inputs.
    ///
    /// # Errors
    /// If there is no input or fewer than two rows, the values are not a whole number of rows, or one is not finite.
    pub fn new(values: Vec<f64>, columns: usize) -> Result<Rows, GaussianProcessError> {
        let bad = |reason: String| Err(GaussianProcessError::Rows(reason));
        if columns == 0 || !values.len().is_multiple_of(columns) {
            return bad(format!("{} values are not a whole number of rows of {columns}", values.len()));
        }
        if values.len() < 2 * columns {
            return bad(format!(
                "there is {} row; a Gaussian process needs two or more",
                values.len() / columns
            ));
        }
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            let (row, input) = (place / columns + 1, place % columns + 1);
            return bad(format!("row {row}: input {input} is {}, not a finite number", values[place]));
        }
        Ok(Rows { values, columns })
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.values.len() / self.columns
    }

    /// Number of inputs.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All values in row-major order.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// A row.
    pub fn row(&self, k: usize) -> &[f64] {
        &self.values[k * self.columns..(k + 1) * self.columns]
    }

    /// Every so many rows that at most `most` are left, evenly spread.
    pub(super) fn thinned(&self, most: usize) -> Vec<usize> {
        let (count, most) = (self.count(), most.max(2));
        if count <= most {
            return (0..count).collect();
        }
        (0..most).map(|k| k * count / most).collect()
    }

    /// The rows of the given numbers.
    pub(super) fn at(&self, rows: &[usize]) -> Rows {
        let values = rows.iter().flat_map(|&k| self.row(k).iter().copied()).collect();
        Rows { values, columns: self.columns }
    }
}

/// Rows with eight of them side by side.
#[derive(Clone, Debug)]
pub(super) struct RowLanes {
    pub count: usize,
    pub blocks: usize,
    pub columns: usize,
    values: Vec<f64>,
    /// Input `d` of the rows of a block at `block * columns + d`.
    lanes: Vec<Row8>,
    /// For each block 1 where there is a row, 0 beyond the last one.
    pub present: Vec<Row8>,
}

impl RowLanes {
    pub fn new(rows: &Rows) -> RowLanes {
        let (count, columns) = (rows.count(), rows.columns());
        let blocks = count.div_ceil(LANES);
        let mut lanes = vec![Row8::default(); blocks * columns];
        let mut present = vec![Row8::default(); blocks];
        for k in 0..count {
            present[k / LANES].0[k % LANES] = 1.0;
            for (d, value) in rows.row(k).iter().enumerate() {
                lanes[k / LANES * columns + d].0[k % LANES] = *value;
            }
        }
        RowLanes { count, blocks, columns, values: rows.values.clone(), lanes, present }
    }

    /// A row.
    #[inline(always)]
    pub fn row(&self, k: usize) -> &[f64] {
        &self.values[k * self.columns..(k + 1) * self.columns]
    }

    /// An input of the rows of a block.
    #[inline(always)]
    pub fn lanes(&self, block: usize, input: usize) -> &Row8 {
        &self.lanes[block * self.columns + input]
    }
}
