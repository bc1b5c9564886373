//! An error over all states of unseen runs, with its standard error over the runs.

use serde::{Deserialize, Serialize};

/// The root of the sum of squared errors over the sum of squared values of all runs, with the standard error that follows from
/// the differences between the runs.
///
/// ```
/// use granum_learn::PooledError;
///
/// // Three runs: the sum of the squared errors and of the squared values.
/// let error = PooledError::new(&[[0.01, 1.0], [0.02, 1.0], [0.03, 1.0]]);
/// assert!((error.relative - 0.02f64.sqrt()).abs() < 1e-12);
/// // The mean of 0.01, 0.02 and 0.03 has a standard error of 0.01 / sqrt(3), half of which over the root is that of the root.
/// assert!((error.standard_error - 0.01 / 3.0f64.sqrt() / 2.0 / 0.02f64.sqrt()).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PooledError {
    /// The error as a share of the root mean square of the values.
    pub relative: f64,
    /// Its standard error over the runs; 0 for a single run.
    pub standard_error: f64,
    /// Number of runs.
    pub runs: usize,
}

impl PooledError {
    /// From the sum of the squared errors and that of the squared values of each run. The standard error is that of a ratio of two sums
    /// over runs that are drawn independently, to first order.
    pub fn new(runs: &[[f64; 2]]) -> PooledError {
        let [errors, values] = runs.iter().fold([0.0; 2], |[a, b], [e, v]| [a + e, b + v]);
        if values <= 0.0 {
            return PooledError { runs: runs.len(), ..PooledError::default() };
        }
        let (ratio, count) = (errors / values, runs.len() as f64);
        let spread: f64 = runs.iter().map(|[e, v]| (e - ratio * v) * (e - ratio * v)).sum();
        let of_ratio = if count > 1.0 { (spread * count / (count - 1.0)).sqrt() / values } else { 0.0 };
        let relative = ratio.sqrt();
        let standard_error = if relative > 0.0 { 0.5 * of_ratio / relative } else { 0.0 };
        PooledError { relative, standard_error, runs: runs.len() }
    }
}
