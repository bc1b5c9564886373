//! The posterior of the parameters of a covariance: the evidence (marginal likelihood) of the targets times the prior.
//!
//! ```text
//! -ln p = 1/2 y^T A^-1 y + 1/2 ln |A| + sum_p (t_p - m_p)^2 / 2 s_p^2,   A = K + noise I
//! d(-ln p)/dt_p = 1/2 sum_ij (A^-1 - a a^T)_ij dA_ij/dt_p + (t_p - m_p)/s_p^2,   a = A^-1 y
//! ```
//!
//! for targets `y` with mean zero and standard deviation one (Rasmussen and Williams 2006, equations 5.8 and 5.9).

use granum_simd::{Isa, LANES, Row8};

use super::covariance::{Covariance, prior};
use super::rows::Rows;
use crate::minimise::Slope;
use crate::symmetric::{Cholesky, Symmetric};

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
    pub fn new(covariance: &Covariance, rows: &Rows) -> Option<Factorised> {
        let size = rows.count();
        let mut matrix = Symmetric::new(size);
        let (stride, blocks) = (matrix.stride, matrix.blocks);
        covariance.values(rows, &mut |i, j, value| {
            let diagonal = if i == j { covariance.noise() + SLIGHT } else { 0.0 };
            matrix.values[j * stride + i / LANES].0[i % LANES] = value + diagonal;
        });
        for k in size..blocks * LANES {
            matrix.values[k * stride + k / LANES].0[k % LANES] = 1.0;
        }
        let mut factor = Cholesky::new(Isa::detect(), size);
        factor.factorise(&matrix, 0.0).then_some(Factorised { factor, size, blocks })
    }

    /// `A^-1 b`.
    pub fn solve(&self, values: &[f64]) -> Vec<f64> {
        let mut vector = self.packed(values);
        self.factor.solve(&mut vector);
        Row8::numbers(&vector)[..self.size].to_vec()
    }

    /// `b^T A^-1 b`.
    pub fn quadratic(&self, values: &[f64]) -> f64 {
        let mut vector = self.packed(values);
        self.factor.solve_transposed(&mut vector);
        Row8::numbers(&vector).iter().map(|y| y * y).sum()
    }

    /// `A^-1`, row by row.
    pub fn inverse(&self) -> Vec<f64> {
        let mut inverse = Vec::with_capacity(self.size * self.size);
        let mut unit = vec![0.0; self.size];
        for k in 0..self.size {
            unit[k] = 1.0;
            inverse.extend(self.solve(&unit));
            unit[k] = 0.0;
        }
        inverse
    }

    fn packed(&self, values: &[f64]) -> Vec<Row8> {
        let mut vector = vec![Row8::default(); self.blocks];
        for (k, value) in values.iter().enumerate() {
            vector[k / LANES].0[k % LANES] = *value;
        }
        vector
    }
}

/// Minus the logarithm of the posterior, but for a constant, and its gradient; `None` if the covariance is not positive definite.
pub(super) fn posterior(rows: &Rows, targets: &[f64], logarithms: &[f64]) -> Option<Slope> {
    let moderate = |l: &f64| l.abs() < MOST_LOGARITHM;
    if !logarithms.iter().all(moderate) {
        return None;
    }
    let covariance = Covariance::new(rows.columns(), logarithms);
    let factorised = Factorised::new(&covariance, rows)?;
    let solved = factorised.solve(targets);
    let fit: f64 = targets.iter().zip(&solved).map(|(y, a)| y * a).sum();
    let mut value = 0.5 * (fit + factorised.factor.log_determinant());
    let (inverse, size) = (factorised.inverse(), factorised.size);
    let weight = |i: usize, j: usize| inverse[i * size + j] - solved[i] * solved[j];
    let mut gradient = covariance.weighted_gradient(rows, &weight);
    let terms = gradient.iter_mut().zip(logarithms).zip(prior(rows.columns()));
    for ((slope, l), [mean, deviation]) in terms {
        let distance = (l - mean) / deviation;
        *slope = 0.5 * *slope + distance / deviation;
        value += 0.5 * distance * distance;
    }
    value.is_finite().then_some((value, gradient))
}
