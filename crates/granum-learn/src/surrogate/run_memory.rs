//! What a surrogate with memory keeps of a run between two of its states, as a value.

use serde::{Deserialize, Serialize};

/// What a surrogate with memory keeps of a run between two of its states: a value that can be copied, compared and written to a file. From the memory and
/// the inputs of the next state follow the prediction and the next memory, to the bit, whatever was asked in between. The default is the memory before the
/// first state of a run.
///
/// What the numbers mean is known to the surrogate from whose run they come alone. They are finite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunMemory {
    parts: Vec<Vec<f64>>,
}

impl RunMemory {
    /// From the lists of numbers of which it consists; none for that before the first state.
    pub fn new(parts: Vec<Vec<f64>>) -> RunMemory {
        RunMemory { parts }
    }

    /// The lists of numbers of which it consists.
    pub fn parts(&self) -> &[Vec<f64>] {
        &self.parts
    }

    /// True before the first state of a run.
    pub fn is_start(&self) -> bool {
        self.parts.is_empty()
    }
}
