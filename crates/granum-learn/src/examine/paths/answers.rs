//! What is answered about surrogates of any path.

use serde::{Deserialize, Serialize};

use super::held::HeldStates;
use super::work::WorkInCycles;
use crate::pooled_error::PooledError;

/// The error of a method for one quantity and kind of path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathAnswer {
    /// The method, a baseline, or `another sample`: the scatter of single runs about the mean of samples on the same path.
    pub method: String,
    /// What the path consists of: a kind of the path `random`, or `all`.
    pub kind: String,
    /// What is judged: `stress deviator`, `volumetric strain`, `fabric deviator` or `coordination number`.
    pub quantity: String,
    /// Its error; for tensors over the root mean square of the tensor, for scalars over that of the difference from the mean of the training states.
    pub error: PooledError,
}

/// The error of a method at the beginning and at the end of long paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// The method.
    pub method: String,
    /// What is judged.
    pub quantity: String,
    /// Error over the first and over the last tenth of each path.
    pub error: [PooledError; 2],
}

/// All answers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PathAnswers {
    /// Errors on unseen runs.
    pub errors: Vec<PathAnswer>,
    /// The work in closed cycles of strain, of the simulations first.
    pub work: Vec<WorkInCycles>,
    /// Whether intervals hold on unseen runs, of the methods that have intervals.
    pub intervals: Vec<HeldStates>,
    /// Errors at the beginning and the end of long runs, if there are any.
    pub drift: Vec<Drift>,
    /// Whether intervals hold on long runs.
    pub intervals_of_long: Vec<HeldStates>,
}
