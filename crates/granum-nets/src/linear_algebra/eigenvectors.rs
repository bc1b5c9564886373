//! Eigenvalues and eigenvectors of a symmetric matrix by Jacobi's rotations, in the order of rows and columns, so that the results are
//! identical bit by bit on every computer.

/// Rotations sweep over the matrix until it is diagonal, at most so often.
const SWEEPS: usize = 30;

/// Eigenvalues and eigenvectors (in columns, row-major) of a symmetric matrix in row-major order. They are not sorted.
pub fn eigenvectors(mut matrix: Vec<f64>, size: usize) -> (Vec<f64>, Vec<f64>) {
    let mut vectors = vec![0.0; size * size];
    (0..size).for_each(|k| vectors[k * size + k] = 1.0);
    let scale = matrix.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    for _ in 0..SWEEPS {
        let mut largest = 0.0f64;
        for p in 0..size {
            for q in p + 1..size {
                let apart = matrix[p * size + q];
                largest = largest.max(apart.abs());
                if apart.abs() <= 1e-17 * scale {
                    continue;
                }
                let ratio = (matrix[q * size + q] - matrix[p * size + p]) / (2.0 * apart);
                let t = ratio.signum() / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = t * c;
                for k in 0..size {
                    let (a, b) = (matrix[k * size + p], matrix[k * size + q]);
                    (matrix[k * size + p], matrix[k * size + q]) = (c * a - s * b, s * a + c * b);
                }
                for k in 0..size {
                    let (a, b) = (matrix[p * size + k], matrix[q * size + k]);
                    (matrix[p * size + k], matrix[q * size + k]) = (c * a - s * b, s * a + c * b);
                    let (a, b) = (vectors[k * size + p], vectors[k * size + q]);
                    (vectors[k * size + p], vectors[k * size + q]) = (c * a - s * b, s * a + c * b);
                }
            }
        }
        if largest <= 1e-16 * scale {
            break;
        }
    }
    ((0..size).map(|k| matrix[k * size + k]).collect(), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_by_hand() {
        // Eigenvalues 3 and 1 with the vectors (1, 1) and (1, -1).
        let (values, vectors) = eigenvectors(vec![2.0, 1.0, 1.0, 2.0], 2);
        let large = usize::from(values[1] > values[0]);
        assert!((values[large] - 3.0).abs() < 1e-14 && (values[1 - large] - 1.0).abs() < 1e-14, "{values:?}");
        assert!((vectors[large] - vectors[2 + large]).abs() < 1e-14, "{vectors:?}");
    }
}
