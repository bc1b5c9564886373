//! The grains of a sample: number, sizes and material.

use granum_shape::{ShapeEntry, SizeMeasure};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::{LARGEST_RATIO, SizeDescription, SizeDistribution, SizeError, SizeKind, Sizes};
use crate::material::Material;
use crate::mixture::Mixture;

/// The grains: number, sizes and material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Grains {
    /// Number of grains.
    pub count: usize,
    /// Mean diameter d, m.
    pub diameter: f64,
    /// Half-width of the uniform distribution of radii relative to the mean (0: equal grains; 0.1: R (1 ± 0.1)).
    pub spread: f64,
    /// Another distribution of sizes in place of that one.
    #[serde(default, skip_serializing_if = "Sizes::is_standard")]
    pub sizes: Sizes,
    /// What their diameters mean where they are not spheres.
    #[serde(default, skip_serializing_if = "is_by_volume")]
    pub size_measure: SizeMeasure,
    /// Their shapes; empty for spheres.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<ShapeEntry>,
    /// Their material.
    pub material: Material,
    /// Several materials, which replace that one; empty if there is one material. In a case its seed is [`Preparation::seed`](crate::config::Preparation::seed).
    #[serde(default, skip_serializing_if = "Mixture::is_empty")]
    pub mixture: Mixture,
}

fn is_by_volume(measure: &SizeMeasure) -> bool {
    *measure == SizeMeasure::Volume
}

impl Default for Grains {
    fn default() -> Self {
        Grains {
            count: 5000,
            diameter: 1e-4,
            spread: 0.0,
            sizes: Sizes::default(),
            size_measure: SizeMeasure::Volume,
            shapes: Vec::new(),
            material: Material::default(),
            mixture: Mixture::default(),
        }
    }
}

impl Grains {
    /// Coefficient of friction of the material; of several materials the mean over the grains.
    pub fn mean_friction(&self) -> f64 {
        let components = &self.mixture.components;
        if components.is_empty() {
            return self.material.friction;
        }
        components.iter().map(|component| component.share * component.material.friction).sum()
    }
}

/// Shares below the cuts.
pub(super) fn shares_between_cuts(
    distribution: &(impl SizeDistribution + ?Sized),
    grains: &Grains,
) -> [f64; 2] {
    let sizes = &grains.sizes;
    let low = sizes.smallest.map_or(0.0, |cut| distribution.share_below(grains, cut));
    let high = sizes.largest.map_or(1.0, |cut| distribution.share_below(grains, cut));
    [low, high]
}

impl Grains {
    /// Refuses impossible sizes.
    ///
    /// # Errors
    /// The first key that is wrong, and what would be right.
    pub fn check_sizes(&self) -> Result<(), SizeError> {
        let sizes = &self.sizes;
        let distribution = sizes.distribution.distribution();
        let SizeDescription { name, parameters, can_be_cut, .. } = *distribution.description();
        for (key, value) in &sizes.values {
            let known = super::parameters().into_iter().find(|known| known.key == key);
            let Some(known) = known else {
                return Err(SizeError::new("distribution", format!("= {name:?} has no parameter {key:?}")));
            };
            if parameters.iter().all(|parameter| parameter.key != known.key) {
                let message = format!("means nothing with grains.distribution = {name:?}; leave it out");
                return Err(SizeError::new(known.key, message));
            }
            let [low, high] = known.bounds;
            if !(*value >= low && *value <= high) {
                return Err(SizeError::new(
                    known.key,
                    format!("is {value}; it must be from {low} to {high}"),
                ));
            }
        }
        if self.spread != 0.0 && sizes.distribution != SizeKind::UNIFORM {
            let message =
                format!("= {} means nothing with grains.distribution = {name:?}; leave it out", self.spread);
            return Err(SizeError::new("spread", message));
        }
        if !sizes.curve.is_empty() && sizes.distribution != SizeKind::SIEVE_CURVE {
            let message = format!(
                "means nothing with grains.distribution = {name:?}; write distribution = \"sieve-curve\""
            );
            return Err(SizeError::new("sieve_curve", message));
        }
        for (key, cut) in [("smallest", sizes.smallest), ("largest", sizes.largest)] {
            let Some(cut) = cut else { continue };
            if !can_be_cut {
                let message = format!("means nothing with grains.distribution = {name:?}; leave it out");
                return Err(SizeError::new(key, message));
            }
            if !(cut.is_finite() && cut > 0.0) {
                return Err(SizeError::new(key, format!("is {cut} m; it must be positive")));
            }
        }
        if let (Some(smallest), Some(largest)) = (sizes.smallest, sizes.largest)
            && smallest >= largest
        {
            let message = format!("= {smallest} m must be below grains.largest = {largest} m");
            return Err(SizeError::new("smallest", message));
        }
        distribution.check(self)?;
        self.check_range()
    }

    /// Refuses cuts between which nothing lies, diameters of zero, and too wide a range.
    fn check_range(&self) -> Result<(), SizeError> {
        let distribution = self.sizes.distribution.distribution();
        let name = self.sizes.distribution.name();
        let [low, high] = shares_between_cuts(distribution, self);
        // So few grains between the cuts that rounding would decide their sizes.
        if high - low < 1e-9 {
            let cut = if self.sizes.smallest.is_some() { "smallest" } else { "largest" };
            let message = format!(
                "leaves no grains of the distribution {name:?}: choose cuts between which grains lie"
            );
            return Err(SizeError::new(cut, message));
        }
        let [smallest, largest] = self.extremes();
        let positive = smallest.is_finite() && smallest > 0.0;
        if positive && largest <= LARGEST_RATIO * smallest {
            return Ok(());
        }
        let reached = if positive {
            format!(
                "has grains from {smallest:.3e} m to {largest:.3e} m; a ratio of {LARGEST_RATIO} is possible"
            )
        } else {
            "reaches diameters of zero".to_string()
        };
        let message = format!("= {name:?} {reached}: cut it with grains.smallest or grains.largest");
        Err(SizeError::new("distribution", message))
    }

    /// The smallest and the largest diameter, m, without checks.
    fn extremes(&self) -> [f64; 2] {
        let distribution = self.sizes.distribution.distribution();
        if self.sizes.distribution == SizeKind::UNIFORM {
            return [1.0 - self.spread, 1.0 + self.spread].map(|factor| self.diameter * factor);
        }
        let [low, high] = shares_between_cuts(distribution, self);
        let half = 0.5 / self.count.max(1) as f64;
        [half, 1.0 - half].map(|share| distribution.quantile(self, low + (high - low) * share))
    }

    /// The smallest and the largest diameter of a sample, m.
    ///
    /// # Errors
    /// As [`Grains::check_sizes`].
    pub fn size_range(&self) -> Result<[f64; 2], SizeError> {
        self.check_sizes()?;
        Ok(self.extremes())
    }

    /// The diameters of the grains of a sample, m.
    ///
    /// # Errors
    /// As [`Grains::check_sizes`].
    pub fn diameters(&self, random: &mut ChaCha8Rng) -> Result<Vec<f64>, SizeError> {
        self.check_sizes()?;
        Ok(self.sizes.distribution.distribution().diameters(self, random))
    }

    /// The mean diameter by number, m: [`Grains::diameter`] of the default distribution, otherwise that of the quantiles of which
    /// a sample of so many grains consists.
    ///
    /// # Errors
    /// As [`Grains::check_sizes`].
    pub fn mean_diameter(&self) -> Result<f64, SizeError> {
        if [SizeKind::UNIFORM, SizeKind::EQUAL].contains(&self.sizes.distribution) {
            return Ok(self.diameter);
        }
        // A sample of very many grains has the mean of some thousand quantiles.
        let few = Grains { count: self.count.clamp(1, 10_000), ..self.clone() };
        few.check_sizes()?;
        let [low, high] = shares_between_cuts(self.sizes.distribution.distribution(), &few);
        let share = |k: usize| low + (high - low) * ((k as f64 + 0.5) / few.count as f64);
        let sum: f64 =
            (0..few.count).map(|k| few.sizes.distribution.distribution().quantile(&few, share(k))).sum();
        Ok(sum / few.count as f64)
    }

    /// Share of the mass that the cuts leave out, where that is known: of a sieve curve.
    pub fn mass_left_out(&self) -> Option<f64> {
        (self.sizes.distribution == SizeKind::SIEVE_CURVE).then(|| super::curve::mass_left_out(&self.sizes))
    }
}
