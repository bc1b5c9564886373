//! Solution of linear equations with a symmetric positive definite matrix by Cholesky factorisation. Sums have a fixed
//! order, so that the results are identical bit by bit on every computer.

/// The lower triangular factor `L` of a matrix `A = L L^T`, in row-major order.
pub struct Cholesky {
    size: usize,
    lower: Vec<f64>,
}

impl Cholesky {
    /// Factorises a matrix, of which only the lower triangle is read; `None` if it is not positive definite.
    pub fn new(size: usize, matrix: &[f64]) -> Option<Cholesky> {
        let mut lower = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..=i {
                let mut sum = matrix[i * size + j];
                for k in 0..j {
                    sum -= lower[i * size + k] * lower[j * size + k];
                }
                if i == j && !(sum > 0.0 && sum.is_finite()) {
                    return None;
                }
                lower[i * size + j] = if i == j { sum.sqrt() } else { sum / lower[j * size + j] };
            }
        }
        Some(Cholesky { size, lower })
    }

    /// Creates a factorisation from a stored factor; `None` if the factor is invalid.
    pub fn from_lower(size: usize, lower: Vec<f64>) -> Option<Cholesky> {
        let positive = |i: usize| lower[i * size + i] > 0.0;
        let is_factor = lower.len() == size * size
            && lower.iter().all(|value| value.is_finite())
            && (0..size).all(positive);
        is_factor.then_some(Cholesky { size, lower })
    }

    /// The lower triangular factor in row-major order.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// The logarithm of the determinant of `A`.
    pub fn log_determinant(&self) -> f64 {
        2.0 * (0..self.size).map(|i| libm::log(self.lower[i * self.size + i])).sum::<f64>()
    }

    /// Solves `L y = b`: `y . y = b^T A^-1 b`.
    pub fn solve_lower(&self, b: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut y = b.to_vec();
        for i in 0..n {
            let known: f64 = self.lower[i * n..i * n + i].iter().zip(&y).map(|(l, y)| l * y).sum();
            y[i] = (y[i] - known) / self.lower[i * n + i];
        }
        y
    }

    /// Solves `A x = b`.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut x = b.to_vec();
        for i in 0..n {
            for k in 0..i {
                x[i] -= self.lower[i * n + k] * x[k];
            }
            x[i] /= self.lower[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                x[i] -= self.lower[k * n + i] * x[k];
            }
            x[i] /= self.lower[i * n + i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_solved_by_hand() {
        // The factor is (2; 1 3; -1 2 1), and the solution (1, 2, 3).
        let matrix = [4.0, 2.0, -2.0, 2.0, 10.0, 5.0, -2.0, 5.0, 6.0];
        let factor = Cholesky::new(3, &matrix).unwrap();
        assert_eq!(factor.lower, [2.0, 0.0, 0.0, 1.0, 3.0, 0.0, -1.0, 2.0, 1.0]);
        let x = factor.solve(&[2.0, 37.0, 26.0]);
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{x:?}");
        // The determinant is 2^2 3^2 1^2.
        assert!((factor.log_determinant() - 36f64.ln()).abs() < 1e-12);
        assert_eq!(factor.solve_lower(&[2.0, 7.0, 6.0]), [1.0, 2.0, 3.0]);
        assert!(Cholesky::new(2, &[1.0, 2.0, 2.0, 1.0]).is_none());
        assert!(Cholesky::new(1, &[f64::NAN]).is_none());
    }
}
