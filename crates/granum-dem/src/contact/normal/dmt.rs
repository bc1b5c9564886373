//! Normal contact of stiff adhesive spheres (Derjaguin, Muller and Toporov 1975, J. Colloid Interface Sci. 53, 314-326): Hertz's
//! contact with a constant attraction while the spheres touch.
//!
//! With the interface energy Gamma (work of adhesion per area) and `P_c = 2 pi Gamma R*`
//!
//! `N = 4/3 E* a alpha - P_c`, `a = sqrt(R* alpha)`, `dN/dalpha = 2 E* a`, for `alpha > 0`.
//!
//! At separation the force is `-P_c` and jumps to zero: contacts form and break at the same overlap, `alpha = 0`, without
//! hysteresis and without loss. The energy is `8/15 E* R*^(1/2) alpha^(5/2) - P_c alpha`, which is continuous there. Friction is
//! limited by the load of the elastic contact, `F = N + P_c`.
//!
//! The law is the limit of small and stiff spheres (Tabor parameter below 0.1); JKR is that of large and compliant ones.

use granum_simd::Real;

use super::hertz::{self, Hertz, HertzConstants};
use crate::contact::law::description::LawDescription;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalLaw};
use crate::law_constants;

/// Derjaguin, Muller and Toporov (1975).
#[derive(Clone, Copy, Debug)]
pub struct Dmt;

law_constants! {
    /// Constants of the contact of Derjaguin, Muller and Toporov for a pair.
    pub struct DmtConstants<R> {
        /// Those of the elastic contact.
        pub hertz: HertzConstants<R>,
        /// `P_c`, N.
        pub pull_off: R,
    }
}

impl NormalLaw for Dmt {
    type Constants<R: Real> = DmtConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "dmt",
        label: "DMT",
        help: "adhesive, for small or stiff grains: Derjaguin, Muller and Toporov 1975",
        parameters: &[],
    };
    const ADHESIVE: bool = true;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> DmtConstants<f64> {
        DmtConstants {
            hertz: Hertz::prepare(pair, parameters),
            pull_off: 2.0 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius,
        }
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &DmtConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let elastic = Hertz::evaluate(&c.hertz, overlap, touched);
        Normal { force: elastic.force - c.pull_off.keep(elastic.touching), ..elastic }
    }

    /// Without adhesion, as for JKR.
    fn loaded(pair: &PairProperties, _parameters: &[f64], load: f64) -> Normal<f64> {
        hertz::under_load(pair, load)
    }

    /// `8/15 E* sqrt(R*) alpha^(5/2) - P_c alpha`.
    #[inline(always)]
    fn energy<R: Real>(c: &DmtConstants<R>, overlap: R) -> R {
        Hertz::energy(&c.hertz, overlap) - c.pull_off * overlap.max(R::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ContactModel, Material, NormalKind, TangentialKind};
    use crate::contact::impact::collision::collide;

    fn pair(interface_energy: f64) -> PairProperties {
        let material = Material { interface_energy, ..Material::default() };
        PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
    }

    /// Spheres of 0.1 mm with 70 GPa, 0.3 and 0.05 J/m2: overlap, force, contact radius, energy.
    #[test]
    fn forces_are_those_of_the_closed_form() {
        let c = Dmt::prepare(&pair(0.05), &[]);
        let table = [
            (1e-12, -7.853_725_223_718_073e-6, 5e-9, -7.853_879_069_871_919e-18),
            (1e-9, 2.544_226_228_675_15e-7, 1.581_138_830_084_19e-7, -4.610_619_931_237_68e-15),
            (1e-8, 2.485_562_747_762_819e-4, 5e-7, 9.471_012_093_012_81e-13),
        ];
        for (overlap, force, radius, energy) in table {
            let n = Dmt::evaluate(&c, overlap, false);
            let found = [n.force, n.radius, n.friction_load - n.force, Dmt::energy(&c, overlap)];
            let wanted = [force, radius, 7.853_981_633_974_483e-6, energy];
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found / wanted - 1.0).abs() < 1e-8, "{overlap:e}: {found:e} {wanted:e}");
            }
            assert!(n.touching);
        }
        let apart = Dmt::evaluate(&c, -1e-15, true);
        assert!(!apart.touching && apart.force == 0.0 && apart.friction_load == 0.0);
    }

    #[test]
    fn without_adhesion_it_is_hertz() {
        let (d, h) = (Dmt::prepare(&pair(0.0), &[]), Hertz::prepare(&pair(0.0), &[]));
        for overlap in [1e-12, 1e-9, 1e-7] {
            let (a, b) = (Dmt::evaluate(&d, overlap, true), Hertz::evaluate(&h, overlap, true));
            assert_eq!([a.force, a.stiffness, a.friction_load], [b.force, b.stiffness, b.friction_load]);
        }
    }

    /// No energy is lost when a contact forms or breaks: the rebound velocity equals the impact velocity at any velocity.
    #[test]
    fn impacts_without_dashpot_lose_nothing() {
        let material = Material { interface_energy: 0.05, ..Material::default() };
        let contact = ContactModel::new(NormalKind::new(&Dmt), TangentialKind::NO_SLIP, 0.0);
        for speed in [1e-3, 0.05] {
            let impact = collide(&contact, &material, 1e-4, speed, 0.0).unwrap();
            assert!((impact.restitution - 1.0).abs() < 1e-4, "{speed}: {}", impact.restitution);
        }
    }
}
