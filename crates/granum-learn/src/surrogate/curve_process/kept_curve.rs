//! What is kept of a fitted curve.

use serde::{Deserialize, Serialize};

/// The processes of a curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptCurve {
    /// The input, of those beside the coordinate, at whose value the curve starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<usize>,
    pub mean: Vec<f64>,
    pub components: Vec<Vec<f64>>,
    /// Variance at each point that the components do not contain.
    pub rest: Vec<f64>,
    /// Logarithms of the parameters of each process.
    pub parameters: Vec<Vec<f64>>,
    /// For each component its weights in the training runs.
    pub weights: Vec<Vec<f64>>,
}
