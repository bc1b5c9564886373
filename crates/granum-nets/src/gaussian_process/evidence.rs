//! The posterior of the parameters of a covariance: the evidence (marginal likelihood) of the targets times the prior.
//!
//! ```text
//! -ln p = 1/2 y^T A^-1 y + 1/2 ln |A| + sum_p (t_p - m_p)^2 / 2 s_p^2,   A = K + noise I
//! d(-ln p)/dt_p = 1/2 sum_ij (A^-1 - a a^T)_ij dA_ij/dt_p + (t_p - m_p)/s_p^2,   a = A^-1 y
//! ```
//!
//! for targets `y` with mean zero and standard deviation one (Rasmussen and Williams 2006, equations 5.8 and 5.9).

use granum_simd::{Isa, LANES, Row8};

use super::covariance::Covariance;
use super::rows::RowLanes;
use crate::linear_algebra::minimise::Slope;
use crate::linear_algebra::symmetric::{Cholesky, Symmetric};

/// Added to the diagonal beside the noise, so that rows that are equal can be factorised without noise.
const SLIGHT: f64 = 1e-8;

/// Parameters beyond its exponential are not considered.
const MOST_LOGARITHM: f64 = 50.0;

/// The covariance of the targets of rows, factorised.
#[derive(Clone, Debug)]
pub(super) struct Factorised {
    factor: Cholesky,
    size: usize,
    blocks: usize,
}

impl Factorised {
    /// `None` if the matrix is not positive definite.
    pub fn new(covariance: &Covariance, rows: &RowLanes) -> Option<Factorised> {
        let size = rows.count;
        let isa = Isa::detect();
        let mut matrix = Symmetric::new(size);
        let (stride, blocks) = (matrix.stride, matrix.blocks);
        covariance.values(isa, rows, &mut matrix);
        for k in 0..blocks * LANES {
            let diagonal = &mut matrix.values[k * stride + k / LANES].0[k % LANES];
            *diagonal = if k < size { *diagonal + covariance.noise() + SLIGHT } else { 1.0 };
        }
        let factor = Cholesky::of_matrix(isa, matrix)?;
        Some(Factorised { factor, size, blocks })
    }

    /// `A^-1 b`.
    pub fn solve(&self, values: &[f64]) -> Vec<f64> {
        let mut vector = self.packed(values);
        self.factor.solve(&mut vector);
        Row8::numbers(&vector)[..self.size].to_vec()
    }

    /// `b^T A^-1 b`.
    pub fn quadratic(&self, mut vector: Vec<Row8>) -> f64 {
        self.factor.solve_transposed(&mut vector);
        Row8::numbers(&vector).iter().map(|y| y * y).sum()
    }

    /// The matrix `F`, row-major and lower triangular, with `|F b|^2 = b^T A^-1 b`: the solutions for the unit vectors are its columns.
    pub fn inverse_factor(&self) -> Vec<f64> {
        let size = self.size;
        let mut factor = vec![0.0; size * size];
        let mut unit = vec![0.0; size];
        for column in 0..size {
            unit[column] = 1.0;
            let mut vector = self.packed(&unit);
            unit[column] = 0.0;
            self.factor.solve_transposed(&mut vector);
            for (row, value) in Row8::numbers(&vector)[..size].iter().enumerate() {
                factor[row * size + column] = *value;
            }
        }
        factor
    }

    /// The diagonal of `A^-1`.
    pub fn diagonal_of_inverse(&mut self) -> Vec<f64> {
        let size = self.size;
        Factorised::diagonal(&self.factor.inverse(), size)
    }

    /// `A^-1`, row-major.
    pub fn inverse(&mut self) -> Vec<f64> {
        let (size, inverse) = (self.size, self.factor.inverse());
        let upper = |k: usize, s: usize| inverse.values[k * inverse.stride + s / LANES].0[s % LANES];
        (0..size * size).map(|at| (at / size, at % size)).map(|(k, s)| upper(k.min(s), k.max(s))).collect()
    }

    /// The first elements of the diagonal of a matrix.
    pub fn diagonal(matrix: &Symmetric, size: usize) -> Vec<f64> {
        (0..size).map(|k| matrix.values[k * matrix.stride + k / LANES].0[k % LANES]).collect()
    }

    pub fn packed(&self, values: &[f64]) -> Vec<Row8> {
        let mut vector = vec![Row8::default(); self.blocks];
        for (k, value) in values.iter().enumerate() {
            vector[k / LANES].0[k % LANES] = *value;
        }
        vector
    }
}

/// Minus the logarithm of the posterior, with the mean and the standard deviation of the prior of each logarithm, but for a constant, and its gradient; `None` if the covariance is not positive definite.
pub(super) fn posterior(
    rows: &RowLanes,
    targets: &[f64],
    prior: &[[f64; 2]],
    logarithms: &[f64],
) -> Option<Slope> {
    let moderate = |l: &f64| l.abs() < MOST_LOGARITHM;
    if !logarithms.iter().all(moderate) {
        return None;
    }
    let covariance = Covariance::new(rows.columns, logarithms);
    let mut factorised = Factorised::new(&covariance, rows)?;
    let solved = factorised.solve(targets);
    let fit: f64 = targets.iter().zip(&solved).map(|(y, a)| y * a).sum();
    let mut value = 0.5 * (fit + factorised.factor.log_determinant());
    let solved = factorised.packed(&solved);
    let inverse = factorised.factor.inverse();
    let mut gradient = covariance.weighted_gradient(Isa::detect(), rows, &inverse, &solved);
    let terms = gradient.iter_mut().zip(logarithms).zip(prior);
    for ((slope, l), [mean, deviation]) in terms {
        let distance = (l - mean) / deviation;
        *slope = 0.5 * *slope + distance / deviation;
        value += 0.5 * distance * distance;
    }
    value.is_finite().then_some((value, gradient))
}
