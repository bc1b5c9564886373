//! Ridge regression on functions of a coordinate and on the deviations of the inputs from their means along it.
//!
//! ```text
//! answer = B(coordinate) a + sum_k b_k z_k,   z_k = (input_k - B(coordinate) c_k) / s_k
//! ```
//!
//! with functions `B` of the coordinate. An input enters as its deviation from its mean as a function of the coordinate
//! (`c_k`, with the same functions), divided by the standard deviation `s_k` of this deviation. The coefficients minimise
//! the sum of squared errors over the rows plus `sum p_k b_k^2 + 1e-6 |a|^2` (Hoerl and Kennard 1970).

use serde::{Deserialize, Serialize};

use super::cholesky::Cholesky;

/// Penalty on the squared coefficients of the curve, so small that it only keeps the equations solvable.
pub const CURVE_PENALTY: f64 = 1e-6;

/// The deviation of an input from its mean as a function of the coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviation {
    /// Coefficients of the functions for the mean.
    pub mean: Vec<f64>,
    /// Standard deviation from the mean over the rows.
    pub standard_deviation: f64,
}

impl Deviation {
    /// The scaled deviation of a value in a row with the given functions; 0 if the rows do not deviate.
    fn of(&self, value: f64, functions: &[f64]) -> f64 {
        let deviation = value - dot(&self.mean, functions);
        if self.standard_deviation > 0.0 { deviation / self.standard_deviation } else { 0.0 }
    }

    /// The deviations of all columns of inputs; `None` if the equations have no solution.
    pub fn fit(functions: &[Vec<f64>], inputs: &[Vec<f64>]) -> Option<Vec<Deviation>> {
        let rows = functions.len();
        let curve = Equations::new(functions, &vec![CURVE_PENALTY; functions.first().map_or(0, Vec::len)])?;
        let deviation = |values: &Vec<f64>| {
            let mean = curve.solve(functions, values);
            let squares: f64 =
                values.iter().zip(functions).map(|(value, row)| (value - dot(&mean, row)).powi(2)).sum();
            Deviation { standard_deviation: (squares / rows as f64).sqrt(), mean }
        };
        Some(inputs.iter().map(deviation).collect())
    }
}

/// A row of the regression: the functions of the coordinate, followed by the deviations of the inputs.
pub fn row(deviations: &[Deviation], functions: &[f64], inputs: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut row = functions.to_vec();
    row.extend(deviations.iter().zip(inputs).map(|(deviation, value)| deviation.of(value, functions)));
    row
}

/// The factorised normal equations of penalised least squares.
pub struct Equations {
    factor: Cholesky,
}

impl Equations {
    /// The equations for given rows and penalties; `None` if they have no solution.
    pub fn new(rows: &[Vec<f64>], penalties: &[f64]) -> Option<Equations> {
        let size = penalties.len();
        let mut matrix = vec![0.0; size * size];
        for row in rows {
            for i in 0..size {
                for j in 0..=i {
                    matrix[i * size + j] += row[i] * row[j];
                }
            }
        }
        for (i, penalty) in penalties.iter().enumerate() {
            matrix[i * size + i] += penalty;
        }
        Cholesky::new(size, &matrix).map(|factor| Equations { factor })
    }

    /// The coefficients for given targets.
    pub fn solve(&self, rows: &[Vec<f64>], targets: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; rows.first().map_or(0, Vec::len)];
        for (row, target) in rows.iter().zip(targets) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += value * target;
            }
        }
        self.factor.solve(&sums)
    }

    /// The factor of the matrix.
    pub fn factor(&self) -> &Cholesky {
        &self.factor
    }
}

/// The scalar product of two vectors, summed in order.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
