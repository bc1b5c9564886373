//! Normal random numbers that are the same on every computer.

use crate::input_use::SplitMix;

/// Normal numbers of a seed, by the transformation of Box and Muller (1958).
pub(super) struct NormalNumbers {
    random: SplitMix,
    second: Option<f64>,
}

impl NormalNumbers {
    pub fn new(seed: u64) -> NormalNumbers {
        NormalNumbers { random: SplitMix(seed), second: None }
    }

    fn uniform(&mut self) -> f64 {
        ((self.random.next() >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
    }

    pub fn next(&mut self) -> f64 {
        if let Some(second) = self.second.take() {
            return second;
        }
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        let angle = std::f64::consts::TAU * self.uniform();
        self.second = Some(radius * libm::sin(angle));
        radius * libm::cos(angle)
    }
}
