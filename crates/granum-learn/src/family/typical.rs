//! Typical values of inputs that are not given, from the runs of a family.
//!
//! An input that is not given is estimated from those that are, by a quadratic function of them with a small penalty, fitted to the
//! runs of the family:
//!
//! ```text
//! x_k = a + sum_i b_i z_i + sum_(i <= j) c_ij z_i z_j + deviation
//! ```
//!
//! with the known inputs `z`, scaled to mean zero and standard deviation one, those as their logarithms that vary by more than a factor of ten and
//! are spread more evenly so. A quadratic function has no sense outside of the runs that it was fitted to: a known input outside of their range
//! counts with the nearer end. The standard deviation of the runs about it says how uncertain the value is.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock};

use granum_nets::dot;

use crate::curve::{is_logarithmic, range};
use crate::regression::deviations::Equations;

/// Penalty on the square of each coefficient, in rows.
const PENALTY: f64 = 0.3;

/// A typical value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TypicalValue {
    /// The value.
    pub mean: f64,
    /// Standard deviation of the runs about it.
    pub deviation: f64,
}

/// Scales a column of values to mean zero and standard deviation one.
#[derive(Clone, Debug, PartialEq)]
struct Scale {
    is_logarithmic: bool,
    range: [f64; 2],
    mean: f64,
    deviation: f64,
}

impl Scale {
    fn new(values: &[f64]) -> Scale {
        let range = range(values.iter().copied());
        let mut scale = Scale { is_logarithmic: is_logarithmic(values), range, mean: 0.0, deviation: 1.0 };
        let plain: Vec<f64> = values.iter().map(|value| scale.scaled(*value)).collect();
        let count = plain.len() as f64;
        scale.mean = plain.iter().sum::<f64>() / count;
        let square = plain.iter().map(|value| (value - scale.mean).powi(2)).sum::<f64>() / count;
        scale.deviation = if square > 0.0 { square.sqrt() } else { 1.0 };
        scale
    }

    fn scaled(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let value = value.max(low).min(high);
        let value = if self.is_logarithmic { libm::log(value) } else { value };
        (value - self.mean) / self.deviation
    }
}

/// The function by which an input is estimated from others, fitted once to the runs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TypicalFunction {
    scales: Vec<Scale>,
    /// The mean of each function of the known inputs.
    centre: Vec<f64>,
    coefficients: Vec<f64>,
    /// The mean of the input.
    mean: f64,
    deviation: f64,
}

impl TypicalFunction {
    /// That of input `wanted` from the inputs in `known`; `rows` has the inputs of each run.
    fn new(rows: &[Vec<f64>], wanted: usize, known: &[usize]) -> TypicalFunction {
        let column = |input: usize| -> Vec<f64> { rows.iter().map(|row| row[input]).collect() };
        let targets = column(wanted);
        let count = targets.len() as f64;
        let mean = targets.iter().sum::<f64>() / count;
        let scales: Vec<Scale> = known.iter().map(|input| Scale::new(&column(*input))).collect();
        let design: Vec<Vec<f64>> =
            rows.iter().map(|row| functions(&scales, known.iter().map(|input| row[*input]))).collect();
        // The functions about their means, so that the constant needs no penalty.
        let size = design.first().map_or(0, Vec::len);
        let centre: Vec<f64> =
            (0..size).map(|k| design.iter().map(|row| row[k]).sum::<f64>() / count).collect();
        let design: Vec<Vec<f64>> = design.into_iter().map(|row| about(row, &centre)).collect();
        let deviations: Vec<f64> = targets.iter().map(|value| value - mean).collect();
        let equations = if size == 0 { None } else { Equations::new(&design, &vec![PENALTY; size]) };
        let coefficients =
            equations.map_or_else(|| vec![0.0; size], |equations| equations.solve(&design, &deviations));
        let errors = design
            .iter()
            .zip(&deviations)
            .map(|(row, deviation)| (deviation - dot(row, &coefficients)).powi(2));
        let freedom = (count - 1.0 - size as f64).max(1.0);
        let deviation = (errors.sum::<f64>() / freedom).sqrt();
        TypicalFunction { scales, centre, coefficients, mean, deviation }
    }

    /// The typical value where the known inputs have these values, in their order.
    fn at(&self, values: impl Iterator<Item = f64>) -> TypicalValue {
        let own = about(functions(&self.scales, values), &self.centre);
        TypicalValue { mean: self.mean + dot(&own, &self.coefficients), deviation: self.deviation }
    }
}

/// The scaled values and their products.
fn functions(scales: &[Scale], values: impl Iterator<Item = f64>) -> Vec<f64> {
    let scaled: Vec<f64> = scales.iter().zip(values).map(|(scale, value)| scale.scaled(value)).collect();
    let mut all = scaled.clone();
    for (k, one) in scaled.iter().enumerate() {
        all.extend(scaled[..=k].iter().map(|other| one * other));
    }
    all
}

fn about(row: Vec<f64>, centre: &[f64]) -> Vec<f64> {
    row.iter().zip(centre).map(|(value, mean)| value - mean).collect()
}

/// The input that is estimated, and those that are known.
type Estimated = (usize, Vec<usize>);

/// The functions by which typical values are estimated, as far as they have been fitted to the runs of a family: which one is needed depends on what is
/// known and not on its values, so that each is fitted once.
#[derive(Debug, Default)]
pub(super) struct TypicalValues {
    functions: RwLock<BTreeMap<Estimated, Arc<TypicalFunction>>>,
}

impl TypicalValues {
    /// The typical value of input `wanted` where the inputs in `known` have the given values; `rows` has the inputs of each run, the same at
    /// each call.
    pub(super) fn value(&self, rows: &[Vec<f64>], wanted: usize, known: &[(usize, f64)]) -> TypicalValue {
        let inputs: Vec<usize> = known.iter().map(|(input, _)| *input).collect();
        let key = (wanted, inputs);
        let known_function = self.functions.read().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        let function = known_function.unwrap_or_else(|| {
            let fitted = Arc::new(TypicalFunction::new(rows, wanted, &key.1));
            let mut functions = self.functions.write().unwrap_or_else(PoisonError::into_inner);
            functions.entry(key).or_insert(fitted).clone()
        });
        function.at(known.iter().map(|(_, value)| *value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_estimated_from_those_that_are_known() {
        // x_2 = 0.5 + 0.2 ln x_0 + x_1^2 and a deviation of 0.01 of either sign.
        let rows: Vec<Vec<f64>> = (0..80)
            .map(|k| {
                let (a, b) = (1.42f64.powi(k % 9), f64::from(k * 7 % 11) / 10.0);
                let sign = if k % 2 == 0 { 0.01 } else { -0.01 };
                vec![a, b, 0.5 + 0.2 * a.ln() + b * b + sign]
            })
            .collect();
        let values = TypicalValues::default();
        let typical_value =
            |rows: &[Vec<f64>], wanted: usize, known: &[(usize, f64)]| values.value(rows, wanted, known);
        let found = typical_value(&rows, 2, &[(0, 6.0), (1, 0.35)]);
        assert!((found.mean - (0.5 + 0.2 * 6.0f64.ln() + 0.35 * 0.35)).abs() < 0.01, "{found:?}");
        assert!((0.008..0.014).contains(&found.deviation), "{found:?}");
        // What is known of x_2 tells something of x_1.
        let back = typical_value(&rows, 1, &[(0, 6.0), (2, 0.5 + 0.2 * 6.0f64.ln() + 0.64)]);
        assert!((back.mean - 0.8).abs() < 0.1, "{back:?}");
        // Outside of the range of what is known it is what it is at its end.
        let ends = [[0.1, -5.0], [1.0, 0.0]].map(|[a, b]| typical_value(&rows, 2, &[(0, a), (1, b)]).mean);
        assert!(ends[0].to_bits() == ends[1].to_bits() && (ends[0] - 0.5).abs() < 0.02, "{ends:?}");
        // With nothing known it is the mean of the runs.
        let mean = typical_value(&rows, 1, &[]);
        assert!((mean.mean - 0.5).abs() < 0.03 && (0.28..0.36).contains(&mean.deviation), "{mean:?}");
    }
}
