//! Small tensors: trace, deviator, eigenvalues.

use granum_core::assembly::Matrix;

pub use granum_dem::invariants::{axial_deviator as deviator, eigenvalues, trace};

/// Adds `factor * a b^T`.
pub(crate) fn add_dyad(t: &mut Matrix, factor: f64, a: &[f64; 3], b: &[f64; 3]) {
    for i in 0..3 {
        for j in 0..3 {
            t[i][j] += factor * a[i] * b[j];
        }
    }
}

/// The tensor times a number.
pub(crate) fn scaled(t: &Matrix, factor: f64) -> Matrix {
    t.map(|row| row.map(|value| value * factor))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn eigenvalues_of_a_known_tensor() {
        // Eigenvalues of [[2,1,0],[1,2,0],[0,0,5]] are 5, 3 and 1.
        let values = eigenvalues(&[[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 5.0]]);
        for (value, exact) in values.iter().zip([5.0, 3.0, 1.0]) {
            assert!((value - exact).abs() < 1e-14, "{values:?}");
        }
    }

    proptest! {
        #[test]
        fn eigenvalues_keep_the_invariants(x in prop::array::uniform6(-1.0..1.0f64)) {
            let t = [[x[0], x[3], x[4]], [x[3], x[1], x[5]], [x[4], x[5], x[2]]];
            let [a, b, c] = eigenvalues(&t);
            prop_assert!(a >= b && b >= c);
            prop_assert!((a + b + c - trace(&t)).abs() < 1e-13);
            let square: f64 = t.iter().flatten().map(|v| v * v).sum();
            prop_assert!((a * a + b * b + c * c - square).abs() < 1e-13);
            prop_assert!((a * b * c - granum_core::geometry::determinant(&t)).abs() < 1e-13);
        }
    }
}
