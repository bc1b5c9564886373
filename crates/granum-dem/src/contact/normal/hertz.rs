//! Normal contact of elastic spheres without adhesion (Hertz 1882).
//!
//! With overlap alpha, effective radius R* and modulus E*: contact radius `a = sqrt(R* alpha)`, force
//! `N = 4/3 E* a alpha`, stiffness `dN/dalpha = 2 E* a`. The pair touches where `alpha > 0`.

use granum_simd::Real;

use crate::contact::description::Description;
use crate::contact::law::{Normal, NormalLaw};
use crate::contact::limits::LAW_CONSTANTS;
use crate::contact::pair_properties::PairProperties;

/// Hertz (1882).
#[derive(Clone, Copy, Debug)]
pub struct Hertz;

const RADIUS: usize = 0;
const FOUR_THIRDS_MODULUS: usize = 1;
const TWICE_MODULUS: usize = 2;
const ROOT_MODULUS: usize = 3;

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
    const DESCRIPTION: Description = Description {
        name: "hertz",
        label: "Hertz",
        help: "elastic spheres without adhesion",
        parameters: &[],
    };

    fn prepare(pair: &PairProperties, _parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[RADIUS] = pair.effective_radius;
        c[FOUR_THIRDS_MODULUS] = 4.0 / 3.0 * pair.effective_modulus;
        c[TWICE_MODULUS] = 2.0 * pair.effective_modulus;
        c[ROOT_MODULUS] = c[TWICE_MODULUS].sqrt();
        c
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &[R; LAW_CONSTANTS], overlap: R, _touched: R::Mask) -> Normal<R> {
        let alpha = overlap.max(R::zero());
        let radius = (c[RADIUS] * alpha).sqrt();
        let force = c[FOUR_THIRDS_MODULUS] * (radius * alpha);
        let root_radius = radius.sqrt();
        Normal {
            force,
            radius,
            stiffness: c[TWICE_MODULUS] * radius,
            root_stiffness: c[ROOT_MODULUS] * root_radius,
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
    fn energy<R: Real>(c: &[R; LAW_CONSTANTS], overlap: R) -> R {
        let alpha = overlap.max(R::zero());
        R::splat(0.4) * c[FOUR_THIRDS_MODULUS] * (c[RADIUS] * alpha).sqrt() * alpha * alpha
    }
}
