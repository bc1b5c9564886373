//! Parallel bonds of Potyondy and Cundall (2004).
//!
//! Springs at the middle of the bond: `k_n = E_b / l` and `k_s = G_b / l` over its section,
//! ```text
//! normal k_n A,  shear k_s A,  bending k_n I,  twisting k_s J.
//! ```
//! With tension positive the stresses at the edge of the section are `sigma = F_n/A + beta |M_b| r_b / I` and
//! `tau = |F_s|/A + beta |M_t| r_b / J`; the bond ruptures at `sigma = sigma_c` or at `tau = max(0, c - F_n/A tan(phi_b))` (Potyondy and
//! Cundall 2004, equations 16 and 17; the moment factor beta and the Mohr-Coulomb limit as in PFC).

use super::bond_law::{
    BondLaw, BondLoads, BondShape, BondStiffness, Criterion, Eight, LIMITS, each_of_eight, least_energy,
};
use super::strengths::{
    COHESION, FRICTION_ANGLE, MODULUS, MOMENT_FACTOR, POISSONS_RATIO, TENSILE_STRENGTH, shear_modulus,
};
use crate::contact::{LawDescription, LawParameter, Unit};
use granum_simd::Real;

/// Parallel bonds.
#[derive(Debug)]
pub struct ParallelBond;

const STIFFNESS_RATIO: LawParameter = LawParameter::new(
    "stiffness_ratio",
    Unit::NUMBER,
    0.0,
    [0.0, 1e6],
    "Ratio of the normal to the shear stiffness, k_n / k_s; 0: it follows from Poisson's ratio.",
);

const PARAMETERS: &[LawParameter] =
    &[MODULUS, POISSONS_RATIO, STIFFNESS_RATIO, TENSILE_STRENGTH, COHESION, FRICTION_ANGLE, MOMENT_FACTOR];

impl BondLaw for ParallelBond {
    fn description(&self) -> &'static LawDescription {
        const {
            &LawDescription::new(
                "parallel",
                "parallel bonds (Potyondy and Cundall)",
                "springs over the section of a cylinder; ruptures by tension with bending, or by shear after Mohr and Coulomb",
                PARAMETERS,
            )
        }
    }

    fn stiffness(&self, shape: &BondShape, parameters: &[f64]) -> BondStiffness {
        let normal = parameters[0] / shape.length;
        let by_poisson = shear_modulus(parameters[0], parameters[1]) / shape.length;
        let shear = if parameters[2] > 0.0 { normal / parameters[2] } else { by_poisson };
        BondStiffness {
            normal: normal * shape.area(),
            shear: shear * shape.area(),
            bending: normal * shape.second_moment(),
            twisting: shear * 2.0 * shape.second_moment(),
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

/// The constants of the stresses at the edge of a cylinder: `1/A, beta r_b/I, sigma_c, beta r_b/J, c, tan(phi_b)/A`.
pub(super) fn mohr_coulomb(
    shape: &BondShape,
    [tensile_strength, cohesion]: [f64; 2],
    friction_angle: f64,
    moment_factor: f64,
    strength: f64,
) -> [f64; LIMITS] {
    let by_couple = moment_factor * shape.radius / shape.second_moment();
    let (sine, cosine) = libm::sincos(friction_angle);
    [
        1.0 / shape.area(),
        by_couple,
        tensile_strength * strength,
        0.5 * by_couple,
        cohesion * strength,
        sine / cosine / shape.area(),
    ]
}

/// The stresses at the edge of a cylinder over its strengths: by tension, and by shear. The loads are tension, shear, bending and twist.
#[inline(always)]
pub(in crate::bond) fn stresses_over_strengths<R: Real>(
    [tension, shear, bending, twisting]: [R; 4],
    [by_area, by_bending, tensile_strength, by_twist, cohesion, friction]: [R; LIMITS],
) -> [R; 2] {
    let stress = tension * by_area + bending * by_bending;
    let sheared = shear * by_area + twisting * by_twist;
    let strength = cohesion - tension * friction;
    // Where tension has used up the cohesion, nothing holds in shear.
    let ratio = R::select(strength.gt(R::zero()), sheared / strength, R::splat(f64::INFINITY));
    [stress / tensile_strength, ratio]
}

/// The energy of [`BondLaw::least_energy_at_rupture`] where [`stresses_over_strengths`] reaches one: in tension `F_n/A + beta M_b r_b/I` is at
/// least `sigma_c`, in shear `F_s/A + beta M_t r_b/J + F_n tan(phi_b)/A` at least c; compression only lowers both sums.
pub(super) fn least_energy_of_cylinder(
    k: &BondStiffness,
    [by_area, by_bending, tensile_strength, by_twist, cohesion, friction]: &[f64; LIMITS],
) -> f64 {
    let torn = least_energy(*tensile_strength, &[[k.normal, *by_area], [k.bending, *by_bending]]);
    let sheared =
        least_energy(*cohesion, &[[k.shear, *by_area], [k.twisting, *by_twist], [k.normal, *friction]]);
    torn.min(sheared)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The bond of the golden numbers.
    pub(crate) const SHAPE: BondShape = BondShape { radius: 20e-6, length: 0.1e-3 };

    fn parameters() -> Vec<f64> {
        vec![1e9, 0.25, 0.0, 20e6, 15e6, libm::atan(0.5), 1.0]
    }

    /// The ratios of one bond under tension, shear force, bending and twisting couple.
    fn ratios(
        law: &dyn BondLaw,
        parameters: &[f64],
        [tension, shear, bending, twisting]: [f64; 4],
    ) -> [f64; 2] {
        let limits = law.limits(&SHAPE, parameters, 1.0).map(|x| [x; 8]);
        let loads = BondLoads {
            tension: [tension; 8],
            shear: [shear; 8],
            bending: [bending; 8],
            twisting: [twisting; 8],
        };
        law.utilisation(&loads, &limits).map(|row| row[3])
    }

    #[test]
    fn stiffnesses_are_those_of_the_section() {
        let k = ParallelBond.stiffness(&SHAPE, &parameters());
        let golden = [1.256_637_061_4e4, 5.026_548_245_7e3, 1.256_637_061_4e-6, 1.005_309_649_1e-6];
        for (found, golden) in [k.normal, k.shear, k.bending, k.twisting].into_iter().zip(golden) {
            assert!((found / golden - 1.0).abs() < 1e-10, "{found} {golden}");
        }
        let mut given = parameters();
        given[2] = 2.5;
        let by_ratio = ParallelBond.stiffness(&SHAPE, &given).shear;
        assert!((by_ratio / golden[1] - 1.0).abs() < 1e-10);
    }

    #[test]
    fn single_and_combined_loads_rupture_at_the_golden_numbers() {
        let (force, area) = (2.513_274_122_9e-2, SHAPE.area());
        let at = |loads: [f64; 4]| ratios(&ParallelBond, &parameters(), loads);
        let near = |found: f64, right: f64| assert!((found - right).abs() < 1e-8, "{found} {right}");
        near(at([force, 0.0, 0.0, 0.0])[0], 1.0);
        near(at([0.0, 1.884_955_592_2e-2, 0.0, 0.0])[1], 1.0);
        // Compression raises the strength in shear and does not rupture by itself.
        near(at([-force, 3.141_592_653_6e-2, 0.0, 0.0])[1], 1.0);
        near(at([-5.026_548_2e-2, 4.398_229_7e-2, 0.0, 0.0])[1] - 1.0, 0.0);
        near(at([-5.026_548_2e-2, 0.0, 0.0, 0.0])[0], -5.026_548_2e-2 / area / 20e6);
        near(at([0.0, 0.0, 1.256_637_061_4e-7, 0.0])[0], 1.0);
        near(at([0.0, 0.0, 0.0, 1.884_955_592_2e-7])[1], 1.0);
        let combined = |force: f64| at([force, 0.5 * force, 0.2 * force * 20e-6, 0.1 * force * 20e-6]);
        near(combined(1.396_263_401_6e-2)[0], 1.0);
        near(combined(1.570_796_326_8e-2)[1], 1.0);
        // Couples count by the moment factor.
        let mut half = parameters();
        half[6] = 0.5;
        near(ratios(&ParallelBond, &half, [0.0, 0.0, 1.256_637_061_4e-7, 0.0])[0], 0.5);
        // Beyond c / tan(phi) of tension nothing holds in shear; without strengths nothing ruptures.
        assert_eq!(at([2.1 * 15e6 * area, 0.0, 0.0, 0.0])[1], f64::INFINITY);
        let endless = [1e9, 0.25, 0.0, f64::INFINITY, f64::INFINITY, 0.5, 1.0];
        assert_eq!(ratios(&ParallelBond, &endless, [1e9, 1e9, 1e9, 1e9]), [0.0, 0.0]);
    }
}
