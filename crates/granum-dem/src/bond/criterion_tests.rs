//! Bonds are judged alike one by one and eight at a time, on every instruction set.

use granum_simd::{Isa, Kernel, Lanes, dispatch};

use super::law::additive::sum_of_ratios;
use super::law::bond_law::{BondLaw, BondLoads, Criterion, Eight, LIMITS};
use super::law::kind::BondKind;
use super::law::parallel::stresses_over_strengths;

struct Evaluate<'a>(Criterion, &'a BondLoads, &'a [Eight; LIMITS]);

impl Kernel for Evaluate<'_> {
    type Output = [Eight; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Eight; 2] {
        let Evaluate(criterion, of, limits) = self;
        let loads = [L::load(&of.tension), L::load(&of.shear), L::load(&of.bending), L::load(&of.twisting)];
        let limits = limits.map(
            #[inline(always)]
            |row| L::load(&row),
        );
        let ratios = match criterion {
            Criterion::Additive => sum_of_ratios(loads, limits),
            _ => stresses_over_strengths(loads, limits),
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
