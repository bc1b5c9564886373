//! The criteria of granum's own laws for eight bonds at once. The formulas are those of the laws, operation by operation, so that both give
//! the same bits.

use granum_simd::Lanes;

/// Stresses over strengths, as `law::parallel` has them: by tension, and by shear. The loads are tension, shear, bending and twist.
#[inline(always)]
pub(super) fn mohr_coulomb<L: Lanes>(
    [tension, shear, bending, twisting]: [L; 4],
    [by_area, by_bending, tensile_strength, by_twist, cohesion, friction]: [L; 6],
) -> [L; 2] {
    let stress = tension * by_area + bending * by_bending;
    let sheared = shear * by_area + twisting * by_twist;
    let strength = cohesion - tension * friction;
    let ratio = L::select(strength.gt(L::zero()), sheared / strength, L::splat(f64::INFINITY));
    [stress / tensile_strength, ratio]
}

/// The sum of the loads over their limits, as `law::additive` has it, where the larger part names the rupture.
#[inline(always)]
pub(super) fn additive<L: Lanes>(loads: [L; 4], limits: [L; 6]) -> [L; 2] {
    let by_tension = loads[0] / limits[0] + loads[2] / limits[2];
    let by_shear = loads[1] / limits[1] + loads[3] / limits[3];
    let (sum, sheared) = (by_tension + by_shear, by_shear.gt(by_tension));
    [L::select(sheared, L::zero(), sum), L::select(sheared, sum, L::zero())]
}

#[cfg(test)]
mod tests {
    use granum_simd::{Isa, Kernel, dispatch};

    use super::*;
    use crate::bond::law::bond_law::{BondLaw, BondLoads, Criterion, Eight, LIMITS};
    use crate::bond::law::kind::BondKind;

    struct Evaluate<'a>(Criterion, &'a BondLoads, &'a [Eight; LIMITS]);

    impl Kernel for Evaluate<'_> {
        type Output = [Eight; 2];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [Eight; 2] {
            let Evaluate(criterion, of, limits) = self;
            let loads =
                [L::load(&of.tension), L::load(&of.shear), L::load(&of.bending), L::load(&of.twisting)];
            let limits = limits.map(
                #[inline(always)]
                |row| L::load(&row),
            );
            let ratios = match criterion {
                Criterion::Additive => additive(loads, limits),
                _ => mohr_coulomb(loads, limits),
            };
            let mut out = [[0.0; 8]; 2];
            ratios[0].store(&mut out[0]);
            ratios[1].store(&mut out[1]);
            out
        }
    }

    #[test]
    fn eight_bonds_are_judged_as_their_law_judges() {
        let mut x = 0.3f64;
        let mut next = || {
            x = (x * 997.0 + 0.618).fract();
            x
        };
        for kind in BondKind::OWN {
            let law: &dyn BondLaw = kind.law();
            for _ in 0..200 {
                let mut eight =
                    |scale: f64, shift: f64| -> Eight { std::array::from_fn(|_| scale * (next() - shift)) };
                let loads = BondLoads {
                    tension: eight(1.0, 0.5),
                    shear: eight(1.0, 0.0),
                    bending: eight(0.1, 0.0),
                    twisting: eight(0.1, 0.0),
                };
                let limits: [Eight; LIMITS] = std::array::from_fn(|_| eight(2.0, 0.0));
                for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                    let found = dispatch(isa, Evaluate(law.criterion(), &loads, &limits));
                    assert_eq!(found, law.utilisation(&loads, &limits), "{kind} {isa:?}");
                }
            }
        }
    }
}
