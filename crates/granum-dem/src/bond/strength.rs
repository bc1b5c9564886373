//! How the strengths of bonds scatter: a factor for each bond, from the seed and the number of the bond.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use crate::random;
use crate::sizes::normal::normal_quantile;

/// Smallest factor of normally distributed strengths.
const LEAST: f64 = 0.1;

/// How the strengths of bonds scatter about those that are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StrengthScatter {
    /// All bonds are equally strong.
    #[default]
    None,
    /// Normally distributed about the given strength, with this standard deviation over the mean; factors below 0.1 are 0.1.
    Normal(f64),
    /// Weibull: a share `exp(-(sigma/sigma_0)^m)` of the bonds carries sigma. With a reference volume the given strength is that of bonds of
    /// this volume, and others have `sigma_0 (V_b/V_0)^(-1/m)`.
    Weibull {
        /// Weibull's modulus m.
        modulus: f64,
        /// Reference volume V_0, m3.
        reference_volume: Option<f64>,
    },
}

impl StrengthScatter {
    /// The factor on the strengths of a bond of a volume, m3, from the seed and the number of the bond.
    pub fn factor(&self, seed: u64, bond: u64, volume: f64) -> f64 {
        let draw = || {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(bond);
            random::unit(&mut rng)
        };
        match *self {
            StrengthScatter::None => 1.0,
            StrengthScatter::Normal(deviation) => (1.0 + deviation * normal_quantile(draw())).max(LEAST),
            StrengthScatter::Weibull { modulus, reference_volume } => {
                let size = reference_volume.map_or(1.0, |of| libm::pow(volume / of, -1.0 / modulus));
                // One minus the draw lies in (0, 1].
                size * libm::pow(-libm::log(1.0 - draw()), 1.0 / modulus)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factors(scatter: StrengthScatter, volume: f64) -> Vec<f64> {
        (0..20_000).map(|bond| scatter.factor(7, bond, volume)).collect()
    }

    fn mean(x: &[f64]) -> f64 {
        x.iter().sum::<f64>() / x.len() as f64
    }

    #[test]
    fn strengths_are_distributed_as_asked() {
        assert!(factors(StrengthScatter::None, 1.0).iter().all(|x| *x == 1.0));
        let normal = factors(StrengthScatter::Normal(0.2), 1.0);
        assert!((mean(&normal) - 1.0).abs() < 0.01 && normal.iter().all(|x| *x >= LEAST));
        let weibull = StrengthScatter::Weibull { modulus: 3.0, reference_volume: Some(2.0) };
        let survive = |x: &[f64], at: f64| x.iter().filter(|x| **x > at).count() as f64 / x.len() as f64;
        let (one, larger) = (factors(weibull, 2.0), factors(weibull, 16.0));
        for at in [0.5, 1.0, 1.5] {
            let share = libm::exp(-libm::pow(at, 3.0));
            assert!((survive(&one, at) - share).abs() < 0.015, "{at}");
            // Eight times the volume is half as strong.
            assert!((survive(&larger, 0.5 * at) - share).abs() < 0.015, "{at}");
        }
        // The same bond of the same seed, whatever came before; another seed is another sample.
        assert_eq!(weibull.factor(7, 19, 2.0), one[19]);
        assert_ne!(weibull.factor(8, 19, 2.0), one[19]);
    }
}
