//! What a state of a material point keeps whose stress a surrogate predicts.

use std::sync::Arc;

use granum_learn::surrogate::{Outside, RunMemory};

/// What a state keeps between two increments of a surrogate.
#[derive(Clone, Debug)]
pub(crate) struct SurrogateState {
    /// The memory of the surrogate.
    pub(crate) memory: RunMemory,
    /// Logarithmic strain since the start, in the axes of the sample: xx, yy, zz, yz, zx, xy, shear strains as angles.
    pub(crate) strain: [f64; 6],
    /// Void ratio at the start, where it is an input.
    pub(crate) void_ratio: Option<f64>,
    /// Names and means of all outputs.
    pub(crate) outputs: Arc<[String]>,
    pub(crate) values: Vec<f64>,
    /// What is outside of the training runs.
    pub(crate) outside: Vec<Outside>,
}

impl SurrogateState {
    /// The mean of an output.
    pub(crate) fn value(&self, column: &str) -> Option<f64> {
        self.outputs.iter().zip(&self.values).find(|(name, _)| *name == column).map(|(_, value)| *value)
    }

    /// The void ratio: that of the surrogate, or `(1 + e0) exp(-eps_v) - 1` where it is known at the start.
    pub(crate) fn void_ratio(&self) -> Option<f64> {
        let volumetric = self.strain[0] + self.strain[1] + self.strain[2];
        let strained = |start: f64| (1.0 + start) * libm::exp(-volumetric) - 1.0;
        self.value("void_ratio").or(self.void_ratio.map(strained))
    }
}
