//! Normal distribution by number.

use libm::{erfc, sqrt};

use super::{Grains, SizeDescription, SizeDistribution, SizeParameter};

/// Diameters `d (1 + c z)` with z of the standard normal distribution and the relative deviation c.
pub struct Normal;

/// Standard deviation over mean, of the normal and the lognormal distribution.
pub(super) const DEVIATION: SizeParameter = SizeParameter {
    key: "size_deviation",
    default: 0.2,
    bounds: [0.001, 2.0],
    meaning: "Standard deviation of the diameters over their mean, by number, before a cut.",
};

/// Share of the standard normal distribution below z.
pub(super) fn normal_share(z: f64) -> f64 {
    0.5 * erfc(-z / sqrt(2.0))
}

/// The z below which a share of the standard normal distribution lies, by bisection. It decides the diameters of samples, so that another way, whose last
/// digits would differ, would change the bits of runs; `granum_nets::normal` serves statistics.
pub(crate) fn normal_quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-40.0, 40.0);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if normal_share(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

impl SizeDistribution for Normal {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "normal",
            help: "normal distribution by number, with the relative deviation size_deviation",
            parameters: &[DEVIATION],
            has_mean: true,
            can_be_cut: true,
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        normal_share((diameter / grains.diameter - 1.0) / grains.sizes.value(&DEVIATION))
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        grains.diameter * (1.0 + grains.sizes.value(&DEVIATION) * normal_quantile(share))
    }
}
