//! Ridge regression on functions of a coordinate and on the deviations of the inputs from their means along it.
//!
//! ```text
//! predicted = B(coordinate) a + sum_k b_k z_k,   z_k = (input_k - B(coordinate) c_k) / s_k
//! ```
//!
//! with functions `B` of the coordinate. An input enters as its deviation from its mean as a function of the coordinate
//! (`c_k`, with the same functions), divided by the standard deviation `s_k` of this deviation. The coefficients minimise
//! the sum of squared errors over the rows plus `sum p_k b_k^2 + 1e-6 |a|^2` (Hoerl and Kennard 1970).

use granum_nets::dot;
use serde::{Deserialize, Serialize};

use super::cholesky::Cholesky;

/// Penalty on the squared coefficients of the curve, so small that it only keeps the equations solvable.
const CURVE_PENALTY: f64 = 1e-6;

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
    fn scaled(&self, value: f64, functions: &[f64]) -> f64 {
        let deviation = value - dot(&self.mean, functions);
        if self.standard_deviation > 0.0 { deviation / self.standard_deviation } else { 0.0 }
    }

    /// The deviations of all columns of inputs; `None` if the equations have no solution.
    fn fit(functions: &[Vec<f64>], inputs: &[Vec<f64>]) -> Option<Vec<Deviation>> {
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
    row.extend(deviations.iter().zip(inputs).map(|(deviation, value)| deviation.scaled(value, functions)));
    row
}

/// The regression of any targets on given rows: the deviations of the inputs, the rows that they give, and the equations.
pub struct Regression {
    deviations: Vec<Deviation>,
    rows: Vec<Vec<f64>>,
    penalties: Vec<f64>,
    equations: Equations,
}

impl Regression {
    /// The regression for the functions of the coordinate in each row and the values of each input in all rows. The penalty on
    /// the squared coefficient of an input is a function of its number and of the standard deviation from its mean along the
    /// coordinate. `None` if the equations have no solution.
    pub fn new(
        functions: &[Vec<f64>],
        inputs: &[Vec<f64>],
        penalty: &dyn Fn(usize, f64) -> f64,
    ) -> Option<Regression> {
        let deviations = Deviation::fit(functions, inputs)?;
        let rows: Vec<Vec<f64>> = (functions.iter().enumerate())
            .map(|(k, functions)| row(&deviations, functions, inputs.iter().map(|values| values[k])))
            .collect();
        let mut penalties = vec![CURVE_PENALTY; functions.first().map_or(0, Vec::len)];
        let of_inputs = deviations.iter().enumerate();
        penalties.extend(of_inputs.map(|(k, deviation)| penalty(k, deviation.standard_deviation)));
        let equations = Equations::new(&rows, &penalties)?;
        Some(Regression { deviations, rows, penalties, equations })
    }

    /// The coefficients for given targets: those of the functions, followed by those of the deviations.
    pub fn coefficients(&self, targets: &[f64]) -> Vec<f64> {
        self.equations.solve(&self.rows, targets)
    }

    /// The deviations of the inputs.
    pub fn deviations(&self) -> &[Deviation] {
        &self.deviations
    }

    /// The deviations of the inputs, without the rest.
    pub fn into_deviations(self) -> Vec<Deviation> {
        self.deviations
    }

    /// The rows, see [`row`].
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// The penalties on the squared coefficients.
    pub fn penalties(&self) -> &[f64] {
        &self.penalties
    }

    /// The factor of the matrix of the equations.
    pub fn factor(&self) -> &Cholesky {
        &self.equations.factor
    }
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
}
