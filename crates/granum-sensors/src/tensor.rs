//! Small tensors: trace, deviator, eigenvalues.

use granum_core::assembly::Matrix;

/// Sum of the diagonal.
pub fn trace(t: &Matrix) -> f64 {
    t[0][0] + t[1][1] + t[2][2]
}

/// Axisymmetric deviator `t_1 - t_3`: axis 1 the axis of compression, axes 2 and 3 averaged.
pub fn deviator(t: &Matrix) -> f64 {
    t[0][0] - 0.5 * (t[1][1] + t[2][2])
}

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

/// Eigenvalues of the symmetric part, largest first (Jacobi rotations; square roots only, so the same bits
/// everywhere).
pub fn eigenvalues(t: &Matrix) -> [f64; 3] {
    let mut a: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (t[i][j] + t[j][i])));
    // Cyclic Jacobi converges quadratically; a 3 x 3 tensor needs 4 to 5 sweeps.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, p, q);
        }
    }
    let mut values = [a[0][0], a[1][1], a[2][2]];
    values.sort_by(|x, y| y.total_cmp(x));
    values
}

/// One Jacobi rotation that makes `a[p][q]` zero.
fn rotate(a: &mut Matrix, p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    if !t.is_finite() || t == 0.0 {
        return;
    }
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for k in 0..3 {
        let (x, y) = (a[k][p], a[k][q]);
        a[k][p] = c * x - s * y;
        a[k][q] = s * x + c * y;
    }
    for k in 0..3 {
        let (x, y) = (a[p][k], a[q][k]);
        a[p][k] = c * x - s * y;
        a[q][k] = s * x + c * y;
    }
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
