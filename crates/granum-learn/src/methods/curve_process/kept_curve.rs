//! What is kept of a fitted curve.

use serde::{Deserialize, Serialize};

use super::predicted_curve::Curve;
use super::root::squared;
use super::start_memory::StartMemory;

fn is_false(value: &bool) -> bool {
    !value
}

/// The processes of a curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptCurve {
    /// The input, of those beside the coordinate, at whose value the curve starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<usize>,
    /// How long it remembers its start; without it always.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory: Option<StartMemory>,
    /// The curves are square roots of the output.
    #[serde(default, skip_serializing_if = "is_false")]
    pub root: bool,
    pub mean: Vec<f64>,
    pub components: Vec<Vec<f64>>,
    /// Variance at each point that the components do not contain.
    pub rest: Vec<f64>,
    /// Logarithms of the parameters of each process.
    pub parameters: Vec<Vec<f64>>,
    /// For each component its weights in the training runs.
    pub weights: Vec<Vec<f64>>,
}

impl KeptCurve {
    /// The output, from what the processes predict.
    pub fn output(&self, curve: Curve) -> Curve {
        if self.root { squared(curve) } else { curve }
    }

    /// What the start of a run with these inputs adds to its curve at a distance from the first point.
    pub fn start_at(&self, inputs: &[f64], distance: f64) -> f64 {
        let start = self.start.map_or(0.0, |input| inputs[input]);
        self.memory.map_or(start, |memory| memory.value(start, distance))
    }
}
