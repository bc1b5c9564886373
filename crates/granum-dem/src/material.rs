//! Properties of the solid and of its surface.

use serde::{Deserialize, Serialize};

/// Properties of the solid and of its surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Material {
    /// Density rho of the solid, kg/m3.
    pub density: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio nu.
    pub poissons_ratio: f64,
    /// Coefficient of friction mu between grains (in shear; the preparation may use another).
    pub friction: f64,
    /// Interface energy Gamma: work of adhesion per area, J/m2. Zero means no adhesion.
    pub interface_energy: f64,
}

impl Material {
    /// Refuses impossible values.
    ///
    /// # Errors
    /// Property, its value in SI units, and what would be right.
    pub(crate) fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        let Material { density, youngs_modulus, poissons_ratio, friction, interface_energy } = *self;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let not_negative = |x: f64| x >= 0.0 && x.is_finite();
        let possible = poissons_ratio > -1.0 && poissons_ratio <= 0.5;
        let table = [
            ("density", density, positive(density), "positive"),
            ("youngs_modulus", youngs_modulus, positive(youngs_modulus), "positive"),
            ("poissons_ratio", poissons_ratio, possible, "above -1 and at most 0.5"),
            ("friction", friction, not_negative(friction), "zero or positive"),
            ("interface_energy", interface_energy, not_negative(interface_energy), "zero or positive"),
        ];
        let wrong = table.into_iter().find(|row| !row.2);
        wrong.map_or(Ok(()), |(name, value, _, right)| Err((name, value, right)))
    }
}

impl Default for Material {
    fn default() -> Self {
        Material {
            density: 2650.0,
            youngs_modulus: 70e9,
            poissons_ratio: 0.3,
            friction: 0.3,
            interface_energy: 0.6,
        }
    }
}
