//! Lognormal distribution by number.

use libm::{exp, log, sqrt};

use super::normal::{DEVIATION, normal_quantile, normal_share};
use super::{Grains, SizeDescription, SizeDistribution};

/// `ln x` is normal with the variance `s² = ln(1 + c²)` and the mean `ln d - s²/2`, so that the diameters have the mean d and the
/// relative deviation c.
pub struct Lognormal;

/// Mean and standard deviation of the logarithm.
fn logarithm(grains: &Grains) -> [f64; 2] {
    let deviation = grains.sizes.value(&DEVIATION);
    let variance = log(1.0 + deviation * deviation);
    [log(grains.diameter) - 0.5 * variance, sqrt(variance)]
}

impl SizeDistribution for Lognormal {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "lognormal",
            help: "lognormal distribution by number, with the relative deviation size_deviation",
            parameters: &[DEVIATION],
            has_mean: true,
            can_be_cut: true,
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        let [mean, deviation] = logarithm(grains);
        normal_share((log(diameter) - mean) / deviation)
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        let [mean, deviation] = logarithm(grains);
        exp(mean + deviation * normal_quantile(share))
    }
}
