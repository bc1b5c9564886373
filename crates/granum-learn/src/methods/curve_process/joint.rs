//! The outputs of one run together: a sample that is by chance stronger than others also dilates more, so that the errors of its curves are
//! correlated from one output to another.

use super::fitted::{CorrelatedCurve, FittedCurves};
use super::root::square_jointly;
use crate::curve::interpolated;
use crate::error::Result;

/// The correlation of the errors of all components of all outputs, in their order.
///
/// Each training run is predicted by the processes of the others (leave one out in closed form); with its errors over their standard deviations
/// `z` the correlation of two components is `s sum z_i z_j / sqrt(sum z_i^2 sum z_j^2)`. The factor `s = n / (n + p)` with n runs and p
/// components shrinks what few runs show by chance.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCorrelation {
    /// The place of the first component of each output.
    first: Vec<usize>,
    count: usize,
    /// Row-major.
    values: Vec<f64>,
}

impl ErrorCorrelation {
    /// From the errors of each component, over their standard deviations, of all runs; `components` counts those of each output.
    fn new(errors: &[Vec<f64>], components: &[usize]) -> ErrorCorrelation {
        let count = errors.len();
        let runs = errors.first().map_or(0, Vec::len) as f64;
        let product = |i: usize, j: usize| errors[i].iter().zip(&errors[j]).map(|(a, b)| a * b).sum::<f64>();
        let squares: Vec<f64> = (0..count).map(|k| product(k, k)).collect();
        let kept = runs / (runs + count as f64).max(1.0);
        let mut values = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                let scale = (squares[i] * squares[j]).sqrt();
                let found = if scale > 0.0 { kept * product(i, j) / scale } else { 0.0 };
                values[i * count + j] = if i == j { 1.0 } else { found };
            }
        }
        let first = (0..components.len()).map(|output| components[..output].iter().sum()).collect();
        ErrorCorrelation { first, count, values }
    }

    fn between(&self, (output, component): (usize, usize), (other, of_other): (usize, usize)) -> f64 {
        self.values[(self.first[output] + component) * self.count + self.first[other] + of_other]
    }
}

/// The correlation of two components; without one they are independent.
fn between(correlation: Option<&ErrorCorrelation>, a: (usize, usize), b: (usize, usize)) -> f64 {
    correlation.map_or(f64::from(u8::from(a == b)), |known| known.between(a, b))
}

/// An output at the values of the coordinate that are asked.
struct Deviations {
    output: usize,
    /// Place of the first of the values in the vector of all.
    from: usize,
    /// For each value the components there, each times the standard deviation of its weight.
    rows: Vec<Vec<f64>>,
}

impl FittedCurves {
    /// The correlation of the errors of the components of all outputs.
    pub fn error_correlation(&self) -> ErrorCorrelation {
        let mut errors = Vec::new();
        for (kept, processes) in self.kept.curves.iter().zip(&self.processes) {
            for (targets, process) in kept.weights.iter().zip(processes) {
                let left = process.left_out(targets);
                let error = |(target, left): (&f64, &granum_nets::gaussian_process::LeftOut)| {
                    (target - left.mean) / left.variance.max(f64::MIN_POSITIVE).sqrt()
                };
                errors.push(targets.iter().zip(&left).map(error).collect());
            }
        }
        let components: Vec<usize> = self.processes.iter().map(Vec::len).collect();
        ErrorCorrelation::new(&errors, &components)
    }

    /// Several outputs of one run, each at increasing values of the coordinate: the means one after another, and the covariance of a run about
    /// them, that of [`FittedCurves::correlated_curve`] with the given correlation between the weights of components.
    ///
    /// # Errors
    /// As [`FittedCurves::correlated_curve`].
    pub fn correlated_curves(
        &self,
        inputs: &[f64],
        asked: &[(usize, &[f64])],
        correlation: &ErrorCorrelation,
    ) -> Result<CorrelatedCurve> {
        self.joint(inputs, asked, Some(correlation))
    }

    /// Several outputs of one run; without a correlation the weights of components are independent.
    pub(super) fn joint(
        &self,
        inputs: &[f64],
        asked: &[(usize, &[f64])],
        correlation: Option<&ErrorCorrelation>,
    ) -> Result<CorrelatedCurve> {
        let points = &self.kept.points;
        let row = self.row(inputs)?;
        let count: usize = asked.iter().map(|(_, at)| at.len()).sum();
        let (mut mean, mut covariance) = (Vec::with_capacity(count), vec![0.0; count * count]);
        let (mut all, mut roots): (Vec<Deviations>, Vec<Option<f64>>) =
            (Vec::new(), Vec::with_capacity(count));
        for (output, at) in asked {
            let (kept, factor) = self.normal_output(*output)?;
            let from = mean.len();
            roots.extend(at.iter().map(|_| kept.root.then_some(factor)));
            let starts: Vec<f64> = points.iter().map(|x| kept.start_at(inputs, x - points[0])).collect();
            let value = |x: &f64| interpolated(*x, points, &starts) + interpolated(*x, points, &kept.mean);
            mean.extend(at.iter().map(value));
            let mut rows = vec![Vec::with_capacity(kept.components.len()); at.len()];
            for (values, process) in kept.components.iter().zip(&self.processes[*output]) {
                let weight = process.predict(&row);
                let deviation = factor * (weight.variance + weight.noise).sqrt();
                for (k, x) in at.iter().enumerate() {
                    let value = interpolated(*x, points, values);
                    mean[from + k] += weight.mean * value;
                    rows[k].push(deviation * value);
                }
            }
            for (k, x) in at.iter().enumerate() {
                let rest = factor * factor * interpolated(*x, points, &kept.rest);
                covariance[(from + k) * count + from + k] += rest;
            }
            all.push(Deviations { output: *output, from, rows });
        }
        for (k, a) in all.iter().enumerate() {
            for b in &all[..=k] {
                let components = b.rows.first().map_or(0, Vec::len);
                for (i, row) in a.rows.iter().enumerate() {
                    let alike = |c: usize| {
                        let of = |d: usize| between(correlation, (a.output, d), (b.output, c));
                        row.iter().enumerate().map(|(d, x)| x * of(d)).sum::<f64>()
                    };
                    let weights: Vec<f64> = (0..components).map(alike).collect();
                    for (j, other) in b.rows.iter().enumerate() {
                        let (p, q) = (a.from + i, b.from + j);
                        if q > p {
                            break;
                        }
                        let product: f64 = weights.iter().zip(other).map(|(x, y)| x * y).sum();
                        covariance[p * count + q] += product;
                        if q < p {
                            covariance[q * count + p] = covariance[p * count + q];
                        }
                    }
                }
            }
        }
        square_jointly(&mut mean, &mut covariance, &roots);
        Ok(CorrelatedCurve { mean, covariance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Golden: errors of four runs, of which the second component follows the first, and the third has nothing to do with them.
    #[test]
    fn correlations_are_shrunk_and_find_their_outputs() {
        let errors = [vec![1.0, -1.0, 1.0, -1.0], vec![2.0, -2.0, 2.0, -2.0], vec![1.0, 1.0, -1.0, -1.0]];
        let found = ErrorCorrelation::new(&errors, &[2, 1]);
        assert!((found.between((0, 0), (0, 1)) - 4.0 / 7.0).abs() < 1e-15);
        assert_eq!((found.between((0, 1), (1, 0)), found.between((1, 0), (1, 0))), (0.0, 1.0));
        assert_eq!(ErrorCorrelation::new(&[], &[0, 0]).count, 0);
    }
}
