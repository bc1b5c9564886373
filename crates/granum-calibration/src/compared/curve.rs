//! Curves that are compared: what the laboratory measured with its error, and what a model predicts with its own.

use serde::{Deserialize, Serialize};

/// Error of a measurement: normal, with the deviation `sqrt(absolute^2 + (relative y)^2)` at a reading y, and a correlation
/// `exp(-|difference of strains| / correlation_strain)` between two readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasurementError {
    /// Absolute part, in the unit of the quantity.
    pub absolute: f64,
    /// Part that is proportional to the reading.
    pub relative: f64,
    /// Difference of strains over which errors are alike; 0 for readings with errors of their own.
    pub correlation_strain: f64,
}

impl MeasurementError {
    /// The standard deviation at a reading.
    pub fn deviation(&self, reading: f64) -> f64 {
        libm::hypot(self.absolute, self.relative * reading)
    }
}

/// One quantity of one test, at strains of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredCurve {
    /// Name of the test.
    pub test: String,
    /// Name of the quantity, a column such as `deviator_stress`.
    pub quantity: String,
    /// Axial strains, rising.
    pub strain: Vec<f64>,
    /// What was measured.
    pub measured: Vec<f64>,
    /// Its error.
    pub error: MeasurementError,
    /// Exponent of the likelihood of this curve; 1 unless curves are weighted.
    pub weight: f64,
}

#[cfg(test)]
impl MeasuredCurve {
    /// A curve for tests: two readings of one, each with an error of its own.
    pub(crate) fn of_ones(quantity: &str) -> MeasuredCurve {
        MeasuredCurve {
            test: "T".into(),
            quantity: quantity.into(),
            strain: vec![0.1, 0.2],
            measured: vec![1.0, 1.0],
            error: MeasurementError { absolute: 0.01, relative: 0.0, correlation_strain: 0.0 },
            weight: 1.0,
        }
    }
}

/// A predicted curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PredictedCurve {
    /// The mean, at the strains of the measured curve.
    pub mean: Vec<f64>,
    /// Covariance of the errors of the prediction, row-major; empty where it has none.
    pub covariance: Vec<f64>,
    /// Covariances with the errors of curves before it in the same list, which are those of one sample: the place of the other curve and a
    /// matrix with a row for each of the strains of this one. Curves that are not named are independent.
    pub across: Vec<(usize, Vec<f64>)>,
}

/// What predicts the measured curves from the values of the free parameters: a surrogate, or anything that is quick enough to be asked
/// tens of thousands of times.
pub trait ForwardModel: Sync {
    /// The curves that belong to the measured ones, in their order; `None` where the model has no prediction, so that such values are
    /// excluded.
    fn predict(&self, values: &[f64]) -> Option<Vec<PredictedCurve>>;
}

impl<F: Fn(&[f64]) -> Option<Vec<PredictedCurve>> + Sync> ForwardModel for F {
    fn predict(&self, values: &[f64]) -> Option<Vec<PredictedCurve>> {
        self(values)
    }
}
