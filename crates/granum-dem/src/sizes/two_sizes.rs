//! Grains of two sizes.

use super::{Grains, SizeDescription, SizeDistribution, SizeParameter};

/// Coarse and fine grains. With the ratio r of their diameters and the share w of the fine grains by mass, the fine grains are the
/// share `n = w r³ / (w r³ + 1 - w)` by number, and the mean diameter d gives the diameter `d / (n + (1 - n) r)` of the fine ones.
pub struct TwoSizes;

const RATIO: SizeParameter = SizeParameter {
    key: "size_ratio",
    default: 2.0,
    bounds: [1.0, 50.0],
    meaning: "Diameter of the coarse grains over that of the fine grains.",
};
const FINE_SHARE: SizeParameter = SizeParameter {
    key: "fine_share",
    default: 0.3,
    bounds: [0.0, 1.0],
    meaning: "Share of the fine grains by mass.",
};

/// Share of the fine grains by number, and the two diameters, m.
fn content(grains: &Grains) -> (f64, [f64; 2]) {
    let (ratio, mass) = (grains.sizes.value(&RATIO), grains.sizes.value(&FINE_SHARE));
    let cube = mass * ratio * ratio * ratio;
    let number = cube / (cube + 1.0 - mass);
    let fine = grains.diameter / (number + (1.0 - number) * ratio);
    (number, [fine, ratio * fine])
}

impl SizeDistribution for TwoSizes {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "two-sizes",
            help: "fine and coarse grains, with size_ratio and fine_share",
            parameters: &[RATIO, FINE_SHARE],
            has_mean: true,
            can_be_cut: false,
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        let (number, [fine, coarse]) = content(grains);
        if diameter <= fine {
            0.0
        } else if diameter <= coarse {
            number
        } else {
            1.0
        }
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        let (number, [fine, coarse]) = content(grains);
        if share < number { fine } else { coarse }
    }
}
