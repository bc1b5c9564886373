//! Weibull distribution by number.

use libm::{exp, log1p, pow, tgamma};

use super::{Grains, SizeDescription, SizeDistribution, SizeParameter};

/// `F(x) = 1 - exp(-(x/l)^m)` with the modulus m; the scale `l = d / Gamma(1 + 1/m)` gives the mean d.
pub struct Weibull;

const MODULUS: SizeParameter = SizeParameter {
    key: "size_modulus",
    default: 3.0,
    bounds: [0.5, 100.0],
    meaning: "Modulus m (exponent) of the Weibull distribution of diameters.",
};

/// Modulus and scale, m.
fn parameters(grains: &Grains) -> [f64; 2] {
    let modulus = grains.sizes.value(&MODULUS);
    [modulus, grains.diameter / tgamma(1.0 + 1.0 / modulus)]
}

impl SizeDistribution for Weibull {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "weibull",
            help: "Weibull distribution by number, with the modulus size_modulus",
            parameters: &[MODULUS],
            has_mean: true,
            can_be_cut: true,
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        let [modulus, scale] = parameters(grains);
        1.0 - exp(-pow(diameter / scale, modulus))
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        let [modulus, scale] = parameters(grains);
        scale * pow(-log1p(-share), 1.0 / modulus)
    }
}
