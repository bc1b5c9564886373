//! Random initial weights after Nguyen and Widrow (1990), reproducible from a seed.
//!
//! As in the toolbox that the paper used, the weights of every neuron have a random direction and the magnitude
//! `0.7 S^(1/R)` for `S` neurons with `R` inputs, the biases distribute the active parts of the activations evenly over the
//! range of the inputs, and both are scaled to the active range of the activation. Weights of neurons without saturation are
//! distributed uniformly in [-1, 1]. Only correctly rounded operations are used, so that a seed gives identical bits on
//! every computer.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::feed_forward::activation::Activation;
use crate::random::uniform;

/// Weights of all layers in the order of [`crate::Network::weights`]. The inputs of the network are assumed to be in [-1,
/// 1].
pub(crate) fn nguyen_widrow(layers: &[usize], activations: &[Activation], seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut weights = Vec::new();
    let mut input_range = (-1.0, 1.0);
    for (shape, &activation) in layers.windows(2).zip(activations) {
        layer(shape[0], shape[1], activation, input_range, &mut random, &mut weights);
        input_range = activation.output_range();
    }
    weights
}

fn layer(
    inputs: usize,
    neurons: usize,
    activation: Activation,
    input_range: (f64, f64),
    random: &mut ChaCha8Rng,
    weights: &mut Vec<f64>,
) {
    let Some((low, high)) = activation.active_range() else {
        weights.extend((0..neurons * (inputs + 1)).map(|_| uniform(random)));
        return;
    };
    let magnitude = 0.7 * root(neurons as f64, inputs);
    let (scale, shift) = (0.5 * (high - low), 0.5 * (high + low));
    // Inputs x in the given range are mapped to (x - centre) / half in [-1, 1].
    let centre = 0.5 * (input_range.0 + input_range.1);
    let half = 0.5 * (input_range.1 - input_range.0);
    for j in 0..neurons {
        let direction: Vec<f64> = (0..inputs).map(|_| uniform(random)).collect();
        let length = direction.iter().fold(0.0, |sum, d| sum + d * d).sqrt().max(f64::MIN_POSITIVE);
        let place = if neurons == 1 { 0.0 } else { -1.0 + 2.0 * j as f64 / (neurons - 1) as f64 };
        let sign = if direction[0] < 0.0 { -1.0 } else { 1.0 };
        let mut bias = scale * magnitude * place * sign + shift;
        for d in direction {
            let weight = scale * magnitude * d / length / half;
            bias -= weight * centre;
            weights.push(weight);
        }
        weights.push(bias);
    }
}

/// `x^(1/n)` for `x >= 1` by bisection, which only needs multiplications.
fn root(x: f64, n: usize) -> f64 {
    let (mut low, mut high) = (1.0, x);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        let mut power = 1.0;
        for _ in 0..n {
            power *= middle;
        }
        if power > x {
            high = middle;
        } else {
            low = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_the_magnitude_of_nguyen_and_widrow() {
        let weights = nguyen_widrow(&[3, 60, 1], &[Activation::Tanh, Activation::Linear], 7);
        let expected = 2.0 * 0.7 * 60f64.powf(1.0 / 3.0);
        for j in 0..60 {
            let row = &weights[4 * j..4 * j + 3];
            let length = row.iter().map(|w| w * w).sum::<f64>().sqrt();
            assert!((length / expected - 1.0).abs() < 1e-12);
            assert!(weights[4 * j + 3].abs() <= expected * (1.0 + 1e-12));
        }
        assert!(weights[240..].iter().all(|w| w.abs() < 1.0));
    }

    #[test]
    fn roots_are_those_of_the_library() {
        for n in [1, 2, 3, 7, 60] {
            for x in [1.0, 2.0, 25.0, 65.0] {
                assert!((root(x, n) / f64::powf(x, 1.0 / n as f64) - 1.0).abs() < 1e-13);
            }
        }
    }
}
