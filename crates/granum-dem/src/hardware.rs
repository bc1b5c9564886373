//! Hardware settings, none of which changes a result.

use granum_simd::Isa;

/// Hardware settings of the simulation; none of them changes a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hardware {
    /// Number of threads that share the work of a step.
    pub threads: usize,
    /// Instruction set.
    pub isa: Isa,
}

impl Default for Hardware {
    fn default() -> Self {
        Hardware { threads: 1, isa: Isa::detect() }
    }
}
