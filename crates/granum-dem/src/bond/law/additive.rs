//! Bonds that rupture when the sum of four ratios reaches one, as those of `bpm/rotational` in LAMMPS.
//!
//! The stiffnesses are those of parallel bonds. With tension positive
//! ```text
//! B = F_n/(sigma_c A) + |F_s|/(c A) + |M_b|/(sigma_c I/r_b) + |M_t|/(c J/r_b)
//! ```
//! (Wang 2009; Clemmer, Monti and Lechman 2024), so that the four loads weaken each other and compression lowers B. Forces are not smoothed
//! near rupture.

use super::bond_law::{
    BondLaw, BondLoads, BondShape, BondStiffness, Criterion, Eight, LIMITS, each_of_eight, least_energy,
};
use super::parallel::ParallelBond;
use super::strengths::{COHESION, MODULUS, POISSONS_RATIO, TENSILE_STRENGTH, single_modes};
use crate::contact::{LawDescription, LawParameter};
use granum_simd::Real;

/// Bonds whose loads add up.
#[derive(Debug)]
pub struct AdditiveBond;

const PARAMETERS: &[LawParameter] = &[MODULUS, POISSONS_RATIO, TENSILE_STRENGTH, COHESION];

impl BondLaw for AdditiveBond {
    fn description(&self) -> &'static LawDescription {
        const {
            &LawDescription::new(
                "additive",
                "bonds whose loads add up (Wang)",
                "stiff as parallel bonds; ruptures where the sum of the four loads over their limits reaches one",
                PARAMETERS,
            )
        }
    }

    fn stiffness(&self, shape: &BondShape, parameters: &[f64]) -> BondStiffness {
        ParallelBond.stiffness(shape, &[parameters[0], parameters[1], 0.0])
    }

    fn limits(&self, shape: &BondShape, parameters: &[f64], strength: f64) -> [f64; LIMITS] {
        let [tension, shear, bending, twisting] =
            single_modes(shape, parameters[2] * strength, parameters[3] * strength);
        [tension, shear, bending, twisting, 0.0, 0.0]
    }

    fn least_energy_at_rupture(&self, k: &BondStiffness, limits: &[f64; LIMITS]) -> f64 {
        let [tension, shear, bending, twisting] = [0, 1, 2, 3].map(|mode| 1.0 / limits[mode]);
        let springs = [[k.normal, tension], [k.shear, shear], [k.bending, bending], [k.twisting, twisting]];
        least_energy(1.0, &springs)
    }

    fn criterion(&self) -> Criterion {
        Criterion::Additive
    }

    fn utilisation(&self, loads: &BondLoads, limits: &[Eight; LIMITS]) -> [Eight; 2] {
        each_of_eight(loads, limits, sum_of_ratios)
    }
}

/// The sum of the loads over their limits, where the larger part names the rupture. The loads are tension, shear, bending and twist.
#[inline(always)]
pub(in crate::bond) fn sum_of_ratios<R: Real>(loads: [R; 4], limits: [R; LIMITS]) -> [R; 2] {
    let by_tension = loads[0] / limits[0] + loads[2] / limits[2];
    let by_shear = loads[1] / limits[1] + loads[3] / limits[3];
    let (sum, sheared) = (by_tension + by_shear, by_shear.gt(by_tension));
    [R::select(sheared, R::zero(), sum), R::select(sheared, sum, R::zero())]
}

#[cfg(test)]
mod tests {
    use super::super::parallel::tests::SHAPE;
    use super::*;

    #[test]
    fn loads_add_up_to_the_golden_force() {
        let limits = AdditiveBond.limits(&SHAPE, &[1e9, 0.25, 20e6, 15e6], 1.0).map(|x| [x; 8]);
        let force = 9.194_905_327_6e-3;
        let loads = BondLoads {
            tension: [force; 8],
            shear: [0.5 * force; 8],
            bending: [0.2 * force * 20e-6; 8],
            twisting: [0.1 * force * 20e-6; 8],
        };
        let [tension, shear] = AdditiveBond.utilisation(&loads, &limits);
        assert!((tension[0] - 1.0).abs() < 1e-9 && shear[0] == 0.0, "{} {}", tension[0], shear[0]);
        // Compression lowers the sum.
        let pressed = BondLoads { tension: [-force; 8], ..loads };
        let [tension, shear] = AdditiveBond.utilisation(&pressed, &limits);
        assert!(tension[0].max(shear[0]) < 0.5);
    }
}
