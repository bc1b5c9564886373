//! The errors on each block of training rows, if the block had not been used for training.

use crate::differentiable::GaussNewton;
use crate::table::data::Data;

/// Errors (output minus target, in scaled units) that the observations of each block would have, to first order, if the
/// block had not been used for training with the ratio `shift` of the precisions of weights and noise; `None` if there are fewer than
/// two blocks, or if the equations have no solution. An observation without weight has no error (NaN).
pub(crate) fn left_out_of(
    problem: &mut dyn GaussNewton,
    weights: &[f64],
    data: &Data,
    shift: f64,
) -> Option<Vec<f64>> {
    if data.block_count() < 2 || data.target_columns() > 1 || !(shift > 0.0 && shift.is_finite()) {
        return None;
    }
    problem.squared_error(weights);
    if !problem.linearise(weights) || !problem.factorise(shift) {
        return None;
    }
    let mut errors = problem.left_out_residuals(data.blocks(), shift)?;
    for (error, weight) in errors.iter_mut().zip(&data.observation_weights()) {
        *error = if *weight > 0.0 { *error / weight.sqrt() } else { f64::NAN };
    }
    Some(errors)
}
