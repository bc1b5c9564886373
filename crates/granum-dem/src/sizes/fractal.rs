//! Fractal distribution: the number of grains larger than x is proportional to a power of x.

use libm::pow;

use super::{Grains, SizeDescription, SizeDistribution, SizeError, SizeParameter};

/// Number of grains larger than x proportional to `x^-D` between the cuts a and b:
/// `F(x) = (a^-D - x^-D) / (a^-D - b^-D)`. With D = 3 each interval of ln x has the same mass.
pub struct Fractal;

const DIMENSION: SizeParameter = SizeParameter {
    key: "fractal_dimension",
    default: 2.5,
    bounds: [0.1, 4.0],
    meaning: "Fractal dimension D: the number of grains larger than x is proportional to x^-D.",
};

/// Dimension, and the powers of the two cuts relative to the smaller.
fn powers(grains: &Grains) -> Option<[f64; 3]> {
    let [a, b] = [grains.sizes.smallest?, grains.sizes.largest?];
    let dimension = grains.sizes.value(&DIMENSION);
    Some([dimension, a, pow(b / a, -dimension)])
}

impl SizeDistribution for Fractal {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "fractal",
            help: "number of larger grains by a power of the diameter, fractal_dimension, between smallest and largest",
            parameters: &[DIMENSION],
            has_mean: false,
            can_be_cut: true,
        }
    }

    fn check(&self, grains: &Grains) -> Result<(), SizeError> {
        match grains.sizes.smallest.and(grains.sizes.largest) {
            Some(_) => Ok(()),
            None => Err(SizeError::new(
                "distribution",
                "= \"fractal\" needs grains.smallest and grains.largest, between which it is defined",
            )),
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        let Some([dimension, a, end]) = powers(grains) else { return f64::NAN };
        ((1.0 - pow(diameter / a, -dimension)) / (1.0 - end)).clamp(0.0, 1.0)
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        let Some([dimension, a, end]) = powers(grains) else { return f64::NAN };
        a * pow(1.0 - share * (1.0 - end), -1.0 / dimension)
    }
}
