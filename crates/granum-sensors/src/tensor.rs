//! Small tensors: trace, deviator, eigenvalues.

use granum_core::assembly::{Matrix, Vector};

pub use granum_dem::invariants::{axial_deviator as deviator, eigenvalues, trace};

/// Adds `factor * a b^T`.
#[inline(always)]
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

/// Double contraction `a:b`.
pub(crate) fn contract(a: &Matrix, b: &Matrix) -> f64 {
    (0..3).map(|i| (0..3).map(|j| a[i][j] * b[i][j]).sum::<f64>()).sum()
}

/// Scalar size of a deviator, `sqrt(3/2 a:a)`, with the sign of `a:reference`; for an axisymmetric one `a_1 - a_3` along the
/// axis of the reference.
pub(crate) fn signed_size(a: &Matrix, reference: &Matrix) -> f64 {
    let size = (1.5 * contract(a, a)).sqrt();
    if contract(a, reference) < 0.0 { -size } else { size }
}

/// Principal values of the symmetric part, largest first, with their unit directions (Jacobi rotations). A direction has a
/// positive first component that is not zero.
pub fn principal(t: &Matrix) -> [(f64, Vector); 3] {
    let mut a: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (t[i][j] + t[j][i])));
    // Column k is the direction of the k-th diagonal element.
    let mut v: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Cyclic Jacobi converges quadratically; 4 to 5 sweeps are enough.
    for _ in 0..12 {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            turned |= rotate(&mut a, &mut v, p, q);
        }
        if !turned {
            break;
        }
    }
    let mut found: [(f64, Vector); 3] =
        std::array::from_fn(|k| (a[k][k], upright(std::array::from_fn(|i| v[i][k]))));
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    found
}

/// The direction or its opposite: the one whose first component that is not zero is positive.
fn upright(v: Vector) -> Vector {
    let first = v.into_iter().find(|x| *x != 0.0).unwrap_or(1.0);
    if first < 0.0 { v.map(|x| -x) } else { v }
}

/// One Jacobi rotation that makes `a[p][q]` zero, applied to the directions too; false if it is zero already.
fn rotate(a: &mut Matrix, v: &mut Matrix, p: usize, q: usize) -> bool {
    if a[p][q].abs() <= 1e-17 * (a[p][p].abs() + a[q][q].abs()) {
        return false;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    if !t.is_finite() || t == 0.0 {
        return false;
    }
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut().chain(v.iter_mut()) {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..3 {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
    true
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
        fn principal_directions_put_the_tensor_together_again(x in prop::array::uniform6(-1.0..1.0f64)) {
            let t = [[x[0], x[3], x[4]], [x[3], x[1], x[5]], [x[4], x[5], x[2]]];
            let found = principal(&t);
            let mut sum = [[0.0; 3]; 3];
            for (value, direction) in &found {
                add_dyad(&mut sum, *value, direction, direction);
                prop_assert!(direction[0] >= 0.0);
            }
            for (value, (own, _)) in eigenvalues(&t).iter().zip(&found) {
                prop_assert!((value - own).abs() < 1e-13);
            }
            for i in 0..3 {
                for j in 0..3 {
                    prop_assert!((sum[i][j] - t[i][j]).abs() < 1e-13);
                }
            }
        }

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
