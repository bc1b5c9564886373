//! Random numbers from a seed, with the same bits on every machine.

use granum_nets::normal::quantile;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The generator of a stream of a seed: streams are independent of each other.
pub(crate) fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random
}

/// A number between 0 and 1, without both.
pub(crate) fn unit(random: &mut ChaCha8Rng) -> f64 {
    ((random.next_u64() >> 11) as f64 + 0.5) * (1.0 / (1u64 << 53) as f64)
}

/// A number of the standard normal distribution.
pub(crate) fn standard_normal(random: &mut ChaCha8Rng) -> f64 {
    quantile(unit(random))
}

/// A whole number below `count`.
pub(crate) fn index(random: &mut ChaCha8Rng, count: usize) -> usize {
    ((unit(random) * count as f64) as usize).min(count - 1)
}
