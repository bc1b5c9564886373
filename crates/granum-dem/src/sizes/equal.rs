//! Equal grains.

use super::{Grains, SizeDescription, SizeDistribution};

/// All grains have the diameter of the case.
pub struct Equal;

impl SizeDistribution for Equal {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "equal",
            help: "all grains have the same diameter",
            parameters: &[],
            has_mean: true,
            can_be_cut: false,
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        f64::from(u8::from(diameter > grains.diameter))
    }

    fn quantile(&self, grains: &Grains, _share: f64) -> f64 {
        grains.diameter
    }
}
