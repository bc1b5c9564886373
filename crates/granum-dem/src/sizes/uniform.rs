//! Radii drawn at random, uniformly in `d/2 (1 ± spread)`.

use rand_chacha::ChaCha8Rng;

use super::{Grains, SizeDescription, SizeDistribution};
use crate::random::unit;

/// Uniform by number, `F(x) = (x - d (1 - s)) / (2 d s)` with the spread s; each radius is a random number of the seed.
pub struct Uniform;

impl SizeDistribution for Uniform {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "uniform",
            help: "radii drawn uniformly around the mean, as wide as spread says; equal grains with spread = 0",
            parameters: &[],
            has_mean: true,
            can_be_cut: false,
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        let relative = diameter / grains.diameter - 1.0;
        if grains.spread == 0.0 {
            return f64::from(u8::from(relative > 0.0));
        }
        (0.5 + 0.5 * relative / grains.spread).clamp(0.0, 1.0)
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        grains.diameter * (1.0 + grains.spread * (2.0 * share - 1.0))
    }

    fn diameters(&self, grains: &Grains, random: &mut ChaCha8Rng) -> Vec<f64> {
        (0..grains.count)
            .map(|_| grains.diameter * (1.0 + grains.spread * (2.0 * unit(random) - 1.0)))
            .collect()
    }
}
