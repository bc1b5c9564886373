//! The measure in which a preparation says how dense a sample is to be, so that answers can be given in the same one.

use crate::config::Preparation;

/// A measure of density.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityMeasure {
    /// Volume of the grains over that of the sample.
    SolidFraction,
    /// Volume of the voids over that of the grains, e = 1/solid fraction - 1.
    VoidRatio,
    /// (e_max - e)/(e_max - e_min).
    RelativeDensity,
}

impl DensityMeasure {
    /// The measure of the target of a preparation; the solid fraction if it has none.
    pub fn new(preparation: &Preparation) -> DensityMeasure {
        match (preparation.void_ratio, preparation.relative_density) {
            (Some(_), _) => DensityMeasure::VoidRatio,
            (None, Some(_)) => DensityMeasure::RelativeDensity,
            (None, None) => DensityMeasure::SolidFraction,
        }
    }

    /// The key of the target in the section `[preparation]` of a case.
    pub fn key(self) -> &'static str {
        match self {
            DensityMeasure::SolidFraction => "solid_fraction",
            DensityMeasure::VoidRatio => "void_ratio",
            DensityMeasure::RelativeDensity => "relative_density",
        }
    }

    /// Its name in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            DensityMeasure::SolidFraction => "solid fraction",
            DensityMeasure::VoidRatio => "void ratio",
            DensityMeasure::RelativeDensity => "relative density",
        }
    }

    /// A solid fraction in this measure; not a number for a relative density without the void ratios between which it is measured.
    pub fn value(self, preparation: &Preparation, solid_fraction: f64) -> f64 {
        let void_ratio = 1.0 / solid_fraction - 1.0;
        match self {
            DensityMeasure::SolidFraction => solid_fraction,
            DensityMeasure::VoidRatio => void_ratio,
            DensityMeasure::RelativeDensity => {
                match (preparation.densest_void_ratio, preparation.loosest_void_ratio) {
                    (Some(densest), Some(loosest)) => (loosest - void_ratio) / (loosest - densest),
                    _ => f64::NAN,
                }
            }
        }
    }

    /// The target as it was given.
    pub fn target(self, preparation: &Preparation) -> Option<f64> {
        match self {
            DensityMeasure::SolidFraction => preparation.solid_fraction,
            DensityMeasure::VoidRatio => preparation.void_ratio,
            DensityMeasure::RelativeDensity => preparation.relative_density,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_told_in_its_own_measure() {
        let given = Preparation::default().with(|p| {
            (p.solid_fraction, p.relative_density) = (None, Some(0.25));
            (p.densest_void_ratio, p.loosest_void_ratio) = (Some(0.55), Some(0.75));
        });
        let measure = DensityMeasure::new(&given);
        assert_eq!((measure, measure.target(&given)), (DensityMeasure::RelativeDensity, Some(0.25)));
        assert!((measure.value(&given, given.target().unwrap()) - 0.25).abs() < 1e-12);
        let given = Preparation::default().with(|p| (p.solid_fraction, p.void_ratio) = (None, Some(0.6)));
        let measure = DensityMeasure::new(&given);
        assert_eq!(measure.key(), "void_ratio");
        assert!((measure.value(&given, 0.625) - 0.6).abs() < 1e-12);
    }
}
