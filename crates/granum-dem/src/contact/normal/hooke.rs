//! Normal contact with a linear spring of given stiffness (Hooke; Cundall and Strack 1979).
//!
//! `N = k_n alpha` where the overlap alpha is positive. `k_n` is a parameter in N/m, the same for every pair, as in other
//! codes with this law: it does not depend on Young's modulus or on the radii. To represent stiff grains, `k_n` should be
//! large compared with `p d` (by a factor of a thousand or more), with the mean stress p and the diameter d.
//!
//! A head-on impact is a damped half oscillation. With the fraction of critical damping zeta and `w_0 = (k_n / m*)^(1/2)` it
//! ends when the overlap vanishes, after `pi / (w_0 (1 - zeta^2)^(1/2))`, with the restitution
//! `exp(-pi zeta / (1 - zeta^2)^(1/2))`.
//!
//! There is no contact area: the tangential law needs a stiffness ratio.

use granum_simd::Real;

use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalLaw};
use crate::law_constants;

/// A linear spring.
#[derive(Clone, Copy, Debug)]
pub struct Hooke;

law_constants! {
    /// Constants of a linear spring for a pair.
    pub struct HookeConstants<R> {
        /// `k_n`, N/m.
        pub stiffness: R,
        /// `k_n^(1/2)`.
        pub root_stiffness: R,
    }
}

/// `contact.normal_stiffness`.
pub(super) const NORMAL_STIFFNESS: LawParameter = LawParameter {
    key: "normal_stiffness",
    unit: Unit::STIFFNESS,
    default: 1e4,
    bounds: [1.0, 1e10],
    meaning: "Stiffness k_n of the linear spring of every contact; at first loading where contacts are plastic",
    without_area: false,
    mixing: Mixing::Harmonic,
};

impl NormalLaw for Hooke {
    type Constants<R: Real> = HookeConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "hooke",
        label: "Hooke",
        help: "a linear spring of stiffness contact.normal_stiffness, without adhesion",
        parameters: &[NORMAL_STIFFNESS],
    };
    const CONTACT_AREA: bool = false;

    fn prepare(_pair: &PairProperties, parameters: &[f64]) -> HookeConstants<f64> {
        let stiffness = parameters[0];
        HookeConstants { stiffness, root_stiffness: stiffness.sqrt() }
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &HookeConstants<R>, overlap: R, _touched: R::Mask) -> Normal<R> {
        let alpha = overlap.max(R::zero());
        let touching = alpha.gt(R::zero());
        let force = c.stiffness * alpha;
        let (stiffness, root) = (c.stiffness.keep(touching), c.root_stiffness.keep(touching));
        Normal {
            force,
            radius: R::zero(),
            stiffness,
            root_stiffness: root,
            tangential_measure: stiffness,
            root_tangential_measure: root,
            friction_load: force,
            touching,
        }
    }

    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        let c = Self::prepare(pair, parameters);
        Self::evaluate(&c, load.max(f64::MIN_POSITIVE) / c.stiffness, true)
    }

    /// `k_n alpha^2 / 2`.
    #[inline(always)]
    fn energy<R: Real>(c: &HookeConstants<R>, overlap: R) -> R {
        let alpha = overlap.max(R::zero());
        R::splat(0.5) * c.stiffness * alpha * alpha
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ContactModel, Material, NormalKind, TangentialKind};
    use crate::contact::impact::collision::collide;

    const DIAMETER: f64 = 1e-4;
    const STIFFNESS: f64 = 2e4;

    fn contact(damping: f64) -> ContactModel {
        let mut contact = ContactModel::new(NormalKind::HOOKE, TangentialKind::NO_SLIP, damping);
        contact.parameters.set("normal_stiffness", STIFFNESS).unwrap();
        contact
    }

    fn pair(damping: f64) -> PairProperties {
        let material = Material::default();
        PairProperties::new((&material, 0.5 * DIAMETER), (&material, 0.5 * DIAMETER), damping)
    }

    #[test]
    fn force_and_energy_are_those_of_a_spring() {
        let c = Hooke::prepare(&pair(0.0), &[STIFFNESS]);
        let n = Hooke::evaluate(&c, 2e-8, true);
        assert_eq!([n.force, n.stiffness, n.radius, n.friction_load], [4e-4, STIFFNESS, 0.0, 4e-4]);
        assert_eq!(Hooke::energy(&c, 2e-8), 0.5 * STIFFNESS * 2e-8 * 2e-8);
        let apart = Hooke::evaluate(&c, -1e-8, true);
        assert!(!apart.touching && apart.force == 0.0 && Hooke::energy(&c, -1e-8) == 0.0);
        assert!((Hooke::loaded(&pair(0.0), &[STIFFNESS], 3e-4).force / 3e-4 - 1.0).abs() < 1e-15);
    }

    /// The damped half oscillation: zeta, restitution, `w_0 t`.
    #[test]
    fn restitution_and_contact_time_are_analytic() {
        let table = [
            (0.0335184491057, 0.9, 3.14335891036),
            (0.215453761966, 0.5, 3.21715051171),
            (0.357857130503, 0.3, 3.36439517813),
        ];
        let period = (pair(0.0).effective_mass / STIFFNESS).sqrt();
        for (damping, restitution, time) in table {
            let impact = collide(&contact(damping), &Material::default(), DIAMETER, 0.01, 0.0).unwrap();
            assert!((impact.restitution - restitution).abs() < 1e-8, "{damping}: {}", impact.restitution);
            let found = impact.contact_time / period;
            assert!((found - time).abs() < 1e-7, "{damping}: {found}");
        }
    }

    /// With `k_t/k_n = 2/7` the tangential motion of solid spheres completes half a period within the half period of the
    /// normal motion: a sticking contact rebounds with the opposite tangential velocity.
    #[test]
    fn a_sticking_oblique_impact_reverses_its_tangential_velocity() {
        let material = Material { friction: 5e3, ..Material::default() };
        let impact = collide(&contact(0.0), &material, DIAMETER, 1e-4, 30.0).unwrap();
        let ratio = impact.tangential_velocity_out / impact.tangential_velocity_in;
        assert!((ratio + 1.0).abs() < 1e-5, "{ratio}");
        assert!((impact.restitution - 1.0).abs() < 1e-5);
        let mut softer = contact(0.0);
        softer.parameters.set("tangential_stiffness_ratio", 0.1).unwrap();
        let impact = collide(&softer, &material, DIAMETER, 1e-4, 30.0).unwrap();
        // cos(pi sqrt(7/2 k_t/k_n)).
        let ratio = impact.tangential_velocity_out / impact.tangential_velocity_in;
        assert!((ratio - (std::f64::consts::PI * 0.35f64.sqrt()).cos()).abs() < 1e-4, "{ratio}");
    }

    #[test]
    fn laws_that_need_a_contact_area_are_refused() {
        for tangential in [TangentialKind::MINDLIN_DERESIEWICZ, TangentialKind::PEELING] {
            let contact = ContactModel { tangential, ..contact(0.1) };
            let error = crate::contact::choice::check::check(&contact).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("contact.tangential = {:?} needs", tangential.name())),
                "{error}"
            );
        }
    }
}
