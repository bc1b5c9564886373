//! The error of tables of rows and of their division into sequences.

/// An error in a table of rows.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DataError {
    /// The number of values is not a multiple of the number of columns, or a count is zero or too large.
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
    /// The number of independent observations is not positive.
    #[error("{0} independent observations; the number must be positive")]
    Observations(f64),
}
