//! Learning curves: error on unseen runs as a function of the number of training runs.
//!
//! On a single path of a single sample every quantity is a function of the coordinate, so that the information of the other
//! inputs, which is in the differences between runs, cannot be detected. The fits of a study are therefore trained on 1, 2, 4, ...
//! runs and scored on the unseen runs, and are compared with the same method on the coordinate alone, with ridge
//! regression, and with the same surrogate that receives the inputs of another unseen run at the same coordinate. A difference
//! counts only if it exceeds its scatter over the unseen runs.
//!
//! Here is what such a curve consists of; a study measures it ([`LearningCurve::measure`]).

use serde::{Deserialize, Serialize};

use crate::student_t::PairedTest;

/// A mean over unseen runs with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeanError {
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean; 0 for a single run.
    pub standard_error: f64,
    /// Number of unseen runs.
    pub runs: usize,
}

impl MeanError {
    /// The mean of one value per run.
    pub fn new(values: &[f64]) -> MeanError {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n.max(1.0);
        let square: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let standard_error = if n > 1.0 { (square / (n - 1.0) / n).sqrt() } else { 0.0 };
        MeanError { mean, standard_error, runs: values.len() }
    }
}

/// Errors of one surrogate for one number of training runs. Errors are relative RMSE on unseen runs, with their standard
/// error over these runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearningPoint {
    /// Name of the fit.
    pub fit: String,
    /// Name of the method.
    pub method: String,
    /// Number of training runs.
    pub training_runs: usize,
    /// Number of different sets of this number of runs, whose errors are averaged.
    pub sets: usize,
    /// Error of the surrogate.
    pub error: MeanError,
    /// Error of the same method on the coordinate alone, or of the mean curve.
    pub coordinate_only: MeanError,
    /// Error of ridge regression with the same inputs; `None` if it could not be fitted.
    pub ridge: Option<MeanError>,
    /// Error of ridge regression on the coordinate alone.
    pub ridge_coordinate_only: Option<MeanError>,
    /// Error with the inputs of another unseen run at the same coordinate; `None` for a single unseen run, or if inputs cannot be
    /// exchanged.
    pub with_other: Option<MeanError>,
    /// Decrease of the error from the coordinate alone to all inputs, with a test whether it exceeds the scatter.
    pub help: PairedTest,
    /// Increase of the error with the inputs of another run.
    pub lost_with_other: Option<PairedTest>,
}

impl LearningPoint {
    /// True if the error is smaller than that from the coordinate alone and increases with the inputs of another run, both
    /// by more than the scatter over the unseen runs.
    pub fn helps(&self) -> bool {
        let used = self.lost_with_other.is_some_and(|lost| lost.above_zero == Some(true));
        used && self.help.above_zero == Some(true)
    }
}

/// Errors as a function of the number of training runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearningCurve {
    /// Number of unseen runs.
    pub unseen_runs: usize,
    /// The points, ordered by fit, then by method, then by number of training runs.
    pub points: Vec<LearningPoint>,
}

/// The numbers of training runs: 1, 2, 4, ... and all.
///
/// ```
/// assert_eq!(granum_learn::learning_curve::doubled(6), [1, 2, 4, 6]);
/// ```
pub fn doubled(all: usize) -> Vec<usize> {
    let mut numbers: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < all).collect();
    numbers.push(all);
    numbers
}
