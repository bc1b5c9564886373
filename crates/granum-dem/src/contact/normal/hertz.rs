//! Normal contact of elastic spheres without adhesion (Hertz 1882).
//!
//! With overlap alpha, effective radius R* and modulus E*: contact radius `a = sqrt(R* alpha)`, force
//! `N = 4/3 E* a alpha`, stiffness `dN/dalpha = 2 E* a`. The pair touches where `alpha > 0`.

use granum_simd::Real;

use crate::contact::law::description::LawDescription;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalLaw};
use crate::law_constants;

/// Hertz (1882).
#[derive(Clone, Copy, Debug)]
pub struct Hertz;

law_constants! {
    /// Constants of Hertz's contact for a pair.
    pub struct HertzConstants<R> {
        /// `R*`, m.
        pub effective_radius: R,
        /// `4/3 E*`, Pa.
        pub four_thirds_modulus: R,
        /// `2 E*`, Pa.
        pub twice_modulus: R,
        /// `(2 E*)^(1/2)`.
        pub root_twice_modulus: R,
    }
}

/// The Hertz contact under a load, N: `a^3 = 3 R* N / 4 E*`.
pub(super) fn under_load(pair: &PairProperties, load: f64) -> Normal<f64> {
    let radius = libm::cbrt(0.75 * load * pair.effective_radius / pair.effective_modulus);
    let stiffness = 2.0 * pair.effective_modulus * radius;
    Normal {
        force: load,
        radius,
        stiffness,
        root_stiffness: stiffness.sqrt(),
        tangential_measure: radius,
        root_tangential_measure: radius.sqrt(),
        friction_load: load,
        touching: true,
    }
}

impl NormalLaw for Hertz {
    type Constants<R: Real> = HertzConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "hertz",
        label: "Hertz",
        help: "elastic spheres without adhesion",
        parameters: &[],
    };

    fn prepare(pair: &PairProperties, _parameters: &[f64]) -> HertzConstants<f64> {
        let twice_modulus = 2.0 * pair.effective_modulus;
        HertzConstants {
            effective_radius: pair.effective_radius,
            four_thirds_modulus: 4.0 / 3.0 * pair.effective_modulus,
            twice_modulus,
            root_twice_modulus: twice_modulus.sqrt(),
        }
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &HertzConstants<R>, overlap: R, _touched: R::Mask) -> Normal<R> {
        let alpha = overlap.max(R::zero());
        let radius = (c.effective_radius * alpha).sqrt();
        let force = c.four_thirds_modulus * (radius * alpha);
        let root_radius = radius.sqrt();
        Normal {
            force,
            radius,
            stiffness: c.twice_modulus * radius,
            root_stiffness: c.root_twice_modulus * root_radius,
            tangential_measure: radius,
            root_tangential_measure: root_radius,
            friction_load: force,
            touching: alpha.gt(R::zero()),
        }
    }

    fn loaded(pair: &PairProperties, _parameters: &[f64], load: f64) -> Normal<f64> {
        under_load(pair, load)
    }

    /// `8/15 E* sqrt(R*) alpha^(5/2)`.
    #[inline(always)]
    fn energy<R: Real>(c: &HertzConstants<R>, overlap: R) -> R {
        let alpha = overlap.max(R::zero());
        R::splat(0.4) * c.four_thirds_modulus * (c.effective_radius * alpha).sqrt() * alpha * alpha
    }
}
