//! Bringing a surrogate to a stress that its caller imposes: it is strained until it has the stress.

use granum_core::geometry::Matrix;
use granum_dem::invariants;
use granum_dem::servo::{PLACES, component};
use granum_run::stiffness::Tensor;

use crate::error::PointError;
use crate::imposed_stress::largest_difference;
use crate::secant;
use crate::straining::AveragedStress;

/// Difference of a component from the imposed stress, over the scale of the stress, that is accepted.
const ACCEPTED: f64 = 5e-4;
/// Largest size of a strain on the way: about that of the increments that surrogates learn.
const LARGEST_STRAIN: f64 = 1e-3;
/// Most strains on the way.
const MOST_STRAINS: u64 = 400;

/// Strains a surrogate until it has a stress, Pa, in the axes of the cell, by Newton's method with a stiffness that follows the answers; gives the stress that is reached,
/// the stiffness and the number of strains. `follow` carries out a strain.
///
/// # Errors
/// [`PointError::StressNotReached`], and as `follow`.
pub(crate) fn impose(
    from: &AveragedStress,
    stiffness: Tensor,
    stress: &Matrix,
    least: f64,
    follow: &mut dyn FnMut(&Matrix) -> Result<AveragedStress, PointError>,
) -> Result<(AveragedStress, Tensor, u64), PointError> {
    let mean_stress = (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0;
    let scale = stress.iter().flatten().fold(least, |scale, x| scale.max(x.abs()));
    let (mut reached, mut stiffness) = (*from, stiffness);
    for strains in 0..MOST_STRAINS {
        let difference = largest_difference(&reached.mean, stress);
        if difference <= ACCEPTED * scale {
            return Ok((reached, stiffness, strains));
        }
        let missing = std::array::from_fn(|k| component(stress, k) - component(&reached.mean, k));
        let Some(strain) = solved(&stiffness.0, missing) else { break };
        let strain = limited(&strain);
        let next = follow(&strain)?;
        stiffness = secant::updated(&stiffness, &strain, &reached.mean, &next.mean);
        reached = next;
    }
    Err(PointError::StressNotReached { difference: largest_difference(&reached.mean, stress), mean_stress })
}

/// The strain of six components, shear strains as angles, and no larger than one on the way.
fn limited(components: &[f64; 6]) -> Matrix {
    let mut strain = [[0.0; 3]; 3];
    for (k, [r, c]) in PLACES.into_iter().enumerate() {
        strain[r][c] += 0.5 * components[k];
        strain[c][r] += 0.5 * components[k];
    }
    let size =
        invariants::length(&strain).max(strain[0][0].abs().max(strain[1][1].abs()).max(strain[2][2].abs()));
    let share = if size > LARGEST_STRAIN { LARGEST_STRAIN / size } else { 1.0 };
    strain.map(|row| row.map(|x| share * x))
}

/// The solution of six linear equations by elimination with row exchange; `None` if there is not one.
fn solved(matrix: &[[f64; 6]; 6], right: [f64; 6]) -> Option<[f64; 6]> {
    let (mut rows, mut right) = (*matrix, right);
    for column in 0..6 {
        let pivot = (column..6).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))?;
        rows.swap(column, pivot);
        right.swap(column, pivot);
        if rows[column][column] == 0.0 || rows[column][column].is_nan() {
            return None;
        }
        for row in column + 1..6 {
            let factor = rows[row][column] / rows[column][column];
            for k in column..6 {
                rows[row][k] -= factor * rows[column][k];
            }
            right[row] -= factor * right[column];
        }
    }
    for row in (0..6).rev() {
        let known: f64 = (row + 1..6).map(|k| rows[row][k] * right[k]).sum();
        right[row] = (right[row] - known) / rows[row][row];
    }
    right.iter().all(|x| x.is_finite()).then_some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_equations_are_solved_where_they_can_be() {
        let matrix: [[f64; 6]; 6] = std::array::from_fn(|r| {
            std::array::from_fn(|c| ((7 * r + 3 * c) as f64).sin() + if r == 5 - c { 3.0 } else { 0.0 })
        });
        let exact = [1.0, -2.0, 0.5, 3.0, -0.25, 4.0];
        let right = std::array::from_fn(|r| (0..6).map(|c| matrix[r][c] * exact[c]).sum());
        let found = solved(&matrix, right).unwrap();
        assert!(found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert!(solved(&[[1.0; 6]; 6], [1.0; 6]).is_none());
        assert!(solved(&[[f64::NAN; 6]; 6], [1.0; 6]).is_none());
    }

    /// A body that is a third as stiff as the first stiffness says.
    #[test]
    fn a_stress_is_reached_or_refused() {
        let start = AveragedStress {
            mean: [[1e5, 0.0, 0.0], [0.0, 1e5, 0.0], [0.0, 0.0, 1e5]],
            deviation: [[0.0; 3]; 3],
        };
        let target = [[2e5, 1e4, 0.0], [1e4, 1.5e5, -2e4], [0.0, -2e4, 1e5]];
        let stiffness =
            Tensor(std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 3e8 } else { 0.0 })));
        let mut stress = start.mean;
        let mut body = |strain: &Matrix| {
            for r in 0..3 {
                for c in 0..3 {
                    stress[r][c] += 1e8 * strain[r][c];
                }
            }
            Ok(AveragedStress { mean: stress, ..start })
        };
        let (reached, secant, strains) = impose(&start, stiffness, &target, 1e3, &mut body).unwrap();
        assert!(largest_difference(&reached.mean, &target) <= 1e2 && strains < 40, "{strains}");
        assert!(secant.0[0][0] < 2e8);
        let error = impose(&start, stiffness, &target, 1e3, &mut |_| Ok(start)).err().unwrap();
        assert!(matches!(error, PointError::StressNotReached { .. }), "{error}");
    }
}
