//! Activation functions of the neurons.

use granum_simd::{Real, sigmoid, tanh};
use serde::{Deserialize, Serialize};

/// The function that gives the output of a neuron from the weighted sum of its inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Hyperbolic tangent, `(1 - exp(-2x)) / (1 + exp(-2x))`, Antony, Zhou and Wang (2006) equation 1.
    Tanh,
    /// Logistic function, `1 / (1 + exp(-x))`, Antony, Zhou and Wang (2006) equation 2.
    Sigmoid,
    /// The identity, `x`.
    Linear,
}

impl Activation {
    /// The output for the weighted sum `x`.
    #[inline(always)]
    pub fn value<R: Real>(self, x: R) -> R {
        match self {
            Activation::Tanh => tanh(x),
            Activation::Sigmoid => sigmoid(x),
            Activation::Linear => x,
        }
    }

    /// Derivative with respect to the weighted sum, as a function of the output `y`: `1 - y^2`, `y (1 - y)` or 1.
    #[inline(always)]
    pub fn slope<R: Real>(self, y: R) -> R {
        let one = R::splat(1.0);
        match self {
            Activation::Tanh => (-y).mul_add(y, one),
            Activation::Sigmoid => (-y).mul_add(y, y),
            Activation::Linear => one,
        }
    }

    /// Range of weighted sums in which the function is far from saturation, used to initialise the weights (Nguyen and
    /// Widrow 1990; the values are those of the toolbox that the paper used). `None` if the function does not saturate.
    pub(crate) fn active_range(self) -> Option<(f64, f64)> {
        match self {
            Activation::Tanh => Some((-2.0, 2.0)),
            Activation::Sigmoid => Some((-4.0, 4.0)),
            Activation::Linear => None,
        }
    }

    /// Range of outputs, used to initialise the weights of the next layer.
    pub(crate) fn output_range(self) -> (f64, f64) {
        match self {
            Activation::Tanh | Activation::Linear => (-1.0, 1.0),
            Activation::Sigmoid => (0.0, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_agree_with_central_differences() {
        for activation in [Activation::Tanh, Activation::Sigmoid, Activation::Linear] {
            for k in -30..=30 {
                let x = 0.13 * k as f64;
                let h = 1e-5;
                let difference = (activation.value(x + h) - activation.value(x - h)) / (2.0 * h);
                assert!(
                    (activation.slope(activation.value(x)) - difference).abs() < 1e-9,
                    "{activation:?} {x}"
                );
            }
        }
    }
}
