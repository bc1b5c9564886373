//! Functions of 3 x 3 matrices: exponential, logarithm of a symmetric matrix, and the polar decomposition, with the same bits everywhere.

use granum_core::geometry::{Matrix, determinant, multiply};
use granum_sensors::tensor::principal;

/// No deformation.
pub(crate) const UNIT: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Terms of the series of the exponential; for matrices of size up to a half the next term is below 1e-20.
const TERMS: u32 = 16;

/// `exp(a) - 1` of a matrix whose entries are at most 1/8 or so, by its series, without the loss of digits of a difference from one.
pub(crate) fn exponential_minus_one(a: &Matrix) -> Matrix {
    // Horner's scheme: a (1 + a/2 (1 + a/3 (1 + ...))).
    let mut sum = UNIT;
    for k in (2..=TERMS).rev() {
        let product = multiply(a, &sum);
        let share = 1.0 / f64::from(k);
        sum = std::array::from_fn(|r| std::array::from_fn(|c| UNIT[r][c] + share * product[r][c]));
    }
    multiply(a, &sum)
}

/// `exp(a)` of any matrix: the series of a part of it, squared as often as it was halved.
pub(crate) fn exponential(a: &Matrix) -> Matrix {
    let size = a.iter().flatten().fold(0.0f64, |size, x| size.max(x.abs()));
    let (mut halvings, mut part) = (0, 1.0);
    while size * part > 0.125 && halvings < 60 {
        halvings += 1;
        part *= 0.5;
    }
    let less = exponential_minus_one(&a.map(|row| row.map(|x| part * x)));
    let mut power: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| UNIT[r][c] + less[r][c]));
    for _ in 0..halvings {
        power = multiply(&power, &power);
    }
    power
}

/// A function of a symmetric matrix, applied to its principal values.
fn of_principal_values(a: &Matrix, function: impl Fn(f64) -> f64) -> Matrix {
    let parts = principal(a).map(|(value, direction)| (function(value), direction));
    std::array::from_fn(|r| {
        std::array::from_fn(|c| parts.iter().map(|(value, n)| value * n[r] * n[c]).sum::<f64>())
    })
}

/// Left stretch and rotation of a deformation gradient `F = V R` with a positive determinant: the logarithm of V, and R.
pub(crate) fn polar(deformation: &Matrix) -> (Matrix, Matrix) {
    let square = multiply(deformation, &transposed(deformation));
    let logarithm = of_principal_values(&square, |value| 0.5 * libm::log(value));
    let inverse = of_principal_values(&square, |value| 1.0 / value.sqrt());
    (logarithm, multiply(&inverse, deformation))
}

/// The transposed matrix.
pub(crate) fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| a[c][r]))
}

/// Largest difference of a matrix from a rotation: `R R^T - 1`, or two for a reflection.
pub(crate) fn difference_from_rotation(a: &Matrix) -> f64 {
    if determinant(a) <= 0.0 {
        return 2.0;
    }
    let product = multiply(a, &transposed(a));
    (0..9).fold(0.0f64, |largest, k| largest.max((product[k / 3][k % 3] - UNIT[k / 3][k % 3]).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(a: &Matrix, b: &Matrix, tolerance: f64) {
        for k in 0..9 {
            assert!((a[k / 3][k % 3] - b[k / 3][k % 3]).abs() < tolerance, "{a:?} {b:?}");
        }
    }

    #[test]
    fn exponentials_of_matrices_whose_exponentials_are_known() {
        let diagonal = [[0.3, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 1e-9]];
        let exact = [[0.3f64.exp(), 0.0, 0.0], [0.0, (-2f64).exp(), 0.0], [0.0, 0.0, 1e-9f64.exp()]];
        assert_near(&exponential(&diagonal), &exact, 4e-15);
        let turn = [[0.0, -0.7, 0.0], [0.7, 0.0, 0.0], [0.0, 0.0, 0.0]];
        let (sine, cosine) = 0.7f64.sin_cos();
        assert_near(
            &exponential(&turn),
            &[[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]],
            1e-15,
        );
        let small = [[1e-13, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
        assert_eq!(exponential_minus_one(&small)[0][0], 1e-13f64.exp_m1());
    }

    #[test]
    fn a_polar_decomposition_puts_the_deformation_together_again() {
        let deformation = [[1.1, 0.4, -0.1], [-0.2, 0.9, 0.05], [0.0, 0.3, 1.2]];
        let (logarithm, rotation) = polar(&deformation);
        assert!(difference_from_rotation(&rotation) < 1e-15);
        assert_near(&multiply(&exponential(&logarithm), &rotation), &deformation, 2e-15);
        assert_eq!(difference_from_rotation(&[[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), 2.0);
    }
}
