//! Errors of a surrogate on unseen runs, output by output.

use crate::dataset::{Dataset, RunStates};
use crate::error::Result;
use crate::pooled_error::PooledError;
use crate::surrogate::{RunInputs, Surrogate};

/// The error on all states of runs for each of the outputs; the name of a histogram stands for all of its bins.
///
/// # Errors
/// If the runs lack a column, or a prediction fails.
pub fn errors_on(surrogate: &dyn Surrogate, runs: &Dataset, outputs: &[String]) -> Result<Vec<PooledError>> {
    let columns = surrogate.columns();
    surrogate.check(runs)?;
    let means = surrogate.means(&RunInputs::from_dataset(runs, columns)?)?;
    let names = columns.output_names();
    let exact = runs.values(&names)?;
    let lengths: Vec<usize> = runs.runs().iter().map(RunStates::rows).collect();
    let error = |output: &String| -> Result<PooledError> {
        let own = runs.expand(&[output])?;
        let places: Vec<usize> = (0..names.len()).filter(|k| own.contains(&names[*k])).collect();
        let mut squares = vec![[0.0; 2]; lengths.len()];
        let mut states = means.iter().zip(exact.chunks_exact(names.len()));
        for (sums, length) in squares.iter_mut().zip(&lengths) {
            for (mean, exact) in states.by_ref().take(*length) {
                for place in &places {
                    sums[0] += (mean[*place] - exact[*place]) * (mean[*place] - exact[*place]);
                    sums[1] += exact[*place] * exact[*place];
                }
            }
        }
        Ok(PooledError::new(&squares))
    };
    outputs.iter().map(error).collect()
}
