//! A secant stiffness that is kept up from increments, by Broyden's (1965) rank-one update.

use granum_core::geometry::Matrix;
use granum_dem::servo::{component, strain_component};
use granum_run::stiffness::Tensor;

/// Size of an increment below which its stresses say more of the motion of the grains than of the stiffness.
const LEAST: f64 = 1e-8;

/// The stiffness that gives the change of stress of an increment and differs least from the one before:
/// `C + (ds - C de) de^T / (de:de)`. Both are in the axes of the cell, compression positive.
pub(crate) fn updated(secant: &Tensor, strain: &Matrix, before: &Matrix, after: &Matrix) -> Tensor {
    let parts: [f64; 6] = std::array::from_fn(|k| strain_component(strain, k));
    // The contraction of tensors: a shear strain as an angle counts half of its square.
    let weight = |k: usize| if k < 3 { 1.0 } else { 0.5 };
    let square: f64 = (0..6).map(|k| weight(k) * parts[k] * parts[k]).sum();
    if square.is_nan() || square.sqrt() < LEAST {
        return *secant;
    }
    let foreseen = secant.stress(strain);
    let mut next = *secant;
    for i in 0..6 {
        let missing = component(after, i) - component(before, i) - foreseen[i];
        for j in 0..6 {
            next.0[i][j] += missing * weight(j) * parts[j] / square;
        }
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After the update the stiffness gives the stress of the increment; along other directions it is as it was.
    #[test]
    fn the_increment_is_met_and_other_directions_are_kept() {
        let before = Tensor::isotropic(2e8, 1e8);
        let strain = [[1e-3, 2e-4, 0.0], [2e-4, -3e-4, 0.0], [0.0, 0.0, 1e-4]];
        let stress = [[3e4, 5e3, 0.0], [5e3, 1e4, 0.0], [0.0, 0.0, 2e4]];
        let next = updated(&before, &strain, &[[0.0; 3]; 3], &stress);
        let given = next.stress(&strain);
        for k in 0..6 {
            assert!((given[k] - component(&stress, k)).abs() < 1e-9 * 3e4, "{given:?}");
        }
        // Orthogonal to the increment in the sense of e:e.
        let across = [[2e-4, -5e-4, 0.0], [-5e-4, 0.0, 0.0], [0.0, 0.0, 0.0]];
        for (new, old) in next.stress(&across).iter().zip(before.stress(&across)) {
            assert!((new - old).abs() < 1e-9 * 1e5, "{new} {old}");
        }
        let tiny = strain.map(|row| row.map(|x| 1e-9 * x));
        assert_eq!(updated(&before, &tiny, &[[0.0; 3]; 3], &stress), before);
    }
}
