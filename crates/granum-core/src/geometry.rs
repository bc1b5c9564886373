//! Vectors and 3 x 3 matrices, computed in a fixed order of fused operations, so that results have the same bits everywhere.

use granum_simd::{Real, mul_add};

/// A vector or a row of a matrix.
pub type Vector = [f64; 3];
/// A 3 x 3 matrix, row by row.
pub type Matrix = [[f64; 3]; 3];

/// Matrix times vector, or times eight vectors.
#[inline(always)]
pub fn apply<R: Real>(m: &Matrix, v: [R; 3]) -> [R; 3] {
    // Written without a closure, which would be compiled for the baseline instruction set inside a kernel.
    [times(&m[0], v), times(&m[1], v), times(&m[2], v)]
}

#[inline(always)]
fn times<R: Real>(row: &Vector, v: [R; 3]) -> R {
    R::splat(row[0]).mul_add(v[0], R::splat(row[1]).mul_add(v[1], R::splat(row[2]) * v[2]))
}

/// Matrix product.
pub fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| {
        std::array::from_fn(|c| mul_add(a[r][0], b[0][c], mul_add(a[r][1], b[1][c], a[r][2] * b[2][c])))
    })
}

/// Inverse of a matrix that is not singular.
pub fn invert(m: &Matrix) -> Matrix {
    let d = determinant(m);
    let minor = |r: usize, c: usize| {
        let (r1, r2) = ((r + 1) % 3, (r + 2) % 3);
        let (c1, c2) = ((c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / d))
}

/// Scalar product, summed in the order of the components.
pub fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length of a vector.
pub fn length(v: &Vector) -> f64 {
    dot(v, v).sqrt()
}

/// Determinant of a 3 x 3 matrix.
pub fn determinant(m: &Matrix) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_product_is_normal_to_both_and_has_the_area_as_its_length() {
        let (a, b) = ([1.0, 2.0, 3.0], [-2.0, 0.5, 4.0]);
        let product = cross(&a, &b);
        assert_eq!(product, [6.5, -10.0, 4.5]);
        assert_eq!((dot(&product, &a), dot(&product, &b)), (0.0, 0.0));
        let area = (dot(&a, &a) * dot(&b, &b) - dot(&a, &b).powi(2)).sqrt();
        assert!((length(&product) - area).abs() < 1e-14 * area);
    }

    #[test]
    fn inverse_of_a_skew_cell() {
        let m = [[2.0, 0.3, -0.1], [0.0, 1.5, 0.2], [0.1, 0.0, 3.0]];
        let product = multiply(&m, &invert(&m));
        for r in 0..3 {
            for c in 0..3 {
                assert!((product[r][c] - f64::from(r == c)).abs() < 1e-15);
            }
        }
    }
}
