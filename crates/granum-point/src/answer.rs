//! The answer of a material point to an increment.

use granum_core::geometry::Matrix;

use crate::state::State;

/// The answer of a material point to an increment.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The state after the increment.
    pub state: State,
    /// Number of steps of the engine, or of a surrogate, that it took when it was computed; an answer that is remembered costs none.
    pub steps: u64,
}

impl Answer {
    /// Stress in the axes of space, Pa, compression positive.
    pub fn stress(&self) -> Matrix {
        self.state.stress()
    }

    /// Standard deviation of each component of the stress, Pa ([`State::noise`]).
    pub fn noise(&self) -> &Matrix {
        self.state.noise()
    }
}
