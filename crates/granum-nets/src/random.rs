//! Random numbers from a seed, with the same bits on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

/// A random number with uniform distribution in (-1, 1), with 53 bits and never zero.
pub(crate) fn uniform(random: &mut ChaCha8Rng) -> f64 {
    let bits = (random.next_u64() >> 11) as f64 + 0.5;
    2.0 * bits / 9_007_199_254_740_992.0 - 1.0
}
