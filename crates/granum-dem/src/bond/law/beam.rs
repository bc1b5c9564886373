//! Bonds that are beams after Timoshenko.
//!
//! Springs at the middle of a bond put shear and bending in series along a chain; a beam that is fixed at both ends has the stiffness in
//! shear
//! ```text
//! 12 E_b I / (l^3 (1 + Phi)),  Phi = 12 E_b I / (kappa G_b A l^2),
//! ```
//! with which the nodes of a chain are those of Timoshenko's beam, however few there are. Tension, bending and twist are `E_b A / l`,
//! `E_b I / l` and `G_b J / l`. Rupture as of parallel bonds.

use super::bond_law::{
    BondLaw, BondLoads, BondShape, BondStiffness, Criterion, Eight, LIMITS, each_of_eight,
};
use super::parallel::{least_energy_of_cylinder, mohr_coulomb, stresses_over_strengths};
use super::strengths::{
    COHESION, FRICTION_ANGLE, MODULUS, MOMENT_FACTOR, POISSONS_RATIO, TENSILE_STRENGTH, shear_modulus,
};
use crate::contact::{LawDescription, LawParameter, Unit};

/// Beams.
#[derive(Debug)]
pub struct BeamBond;

const SHEAR_COEFFICIENT: LawParameter = LawParameter::new(
    "shear_coefficient",
    Unit::NUMBER,
    1.0,
    [0.1, 1e6],
    "Shear coefficient kappa of the section: 6 (1 + nu) / (7 + 6 nu) for a full circle.",
);

const PARAMETERS: &[LawParameter] =
    &[MODULUS, POISSONS_RATIO, SHEAR_COEFFICIENT, TENSILE_STRENGTH, COHESION, FRICTION_ANGLE, MOMENT_FACTOR];

impl BondLaw for BeamBond {
    fn description(&self) -> &'static LawDescription {
        const {
            &LawDescription::new(
                "beam",
                "beams (Timoshenko)",
                "a cylinder that bends and shears as Timoshenko's beam; ruptures as parallel bonds",
                PARAMETERS,
            )
        }
    }

    fn stiffness(&self, shape: &BondShape, parameters: &[f64]) -> BondStiffness {
        let (length, area, moment) = (shape.length, shape.area(), shape.second_moment());
        let shear = shear_modulus(parameters[0], parameters[1]);
        let bending = 12.0 * parameters[0] * moment;
        let phi = bending / (parameters[2] * shear * area * length * length);
        BondStiffness {
            normal: parameters[0] * area / length,
            shear: bending / (length * length * length * (1.0 + phi)),
            bending: parameters[0] * moment / length,
            twisting: shear * 2.0 * moment / length,
        }
    }

    fn limits(&self, shape: &BondShape, parameters: &[f64], strength: f64) -> [f64; LIMITS] {
        mohr_coulomb(shape, [parameters[3], parameters[4]], parameters[5], parameters[6], strength)
    }

    fn least_energy_at_rupture(&self, stiffness: &BondStiffness, limits: &[f64; LIMITS]) -> f64 {
        least_energy_of_cylinder(stiffness, limits)
    }

    fn criterion(&self) -> Criterion {
        Criterion::MohrCoulomb
    }

    fn utilisation(&self, loads: &BondLoads, limits: &[Eight; LIMITS]) -> [Eight; 2] {
        each_of_eight(loads, limits, stresses_over_strengths)
    }
}

#[cfg(test)]
mod tests {
    use super::super::parallel::tests::SHAPE;
    use super::*;

    #[test]
    fn the_shear_stiffness_is_that_of_a_beam_with_fixed_ends() {
        let k = BeamBond.stiffness(&SHAPE, &[1e9, 0.25, 1.0, 1.0, 1.0, 0.0, 1.0]);
        assert!((k.shear / 1.159_972_672_1e3 - 1.0).abs() < 1e-10, "{}", k.shear);
        assert!((k.normal / 1.256_637_061_4e4 - 1.0).abs() < 1e-10);
    }
}
