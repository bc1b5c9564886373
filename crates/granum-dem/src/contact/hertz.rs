//! Normal contact of elastic spheres without adhesion (Hertz 1882).
//!
//! With approach alpha, effective radius R* and modulus E*: contact radius `a = sqrt(R* alpha)`, force
//! `N = 4/3 E* a alpha`, stiffness `dN/dalpha = 2 E* a`. The pair touches where `alpha > 0`.

use granum_simd::Real;

use super::{LAW_CONSTANTS, Normal, NormalLaw, PairProperties};

/// Hertz (1882).
#[derive(Clone, Copy, Debug)]
pub struct Hertz;

const RADIUS: usize = 0;
const FOUR_THIRDS_MODULUS: usize = 1;
const TWICE_MODULUS: usize = 2;
const ROOT_MODULUS: usize = 3;

impl NormalLaw for Hertz {
    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[RADIUS] = pair.effective_radius;
        c[FOUR_THIRDS_MODULUS] = 4.0 / 3.0 * pair.effective_modulus;
        c[TWICE_MODULUS] = 2.0 * pair.effective_modulus;
        c[ROOT_MODULUS] = c[TWICE_MODULUS].sqrt();
        c
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &[R; LAW_CONSTANTS], approach: R, _touched: R::Mask) -> Normal<R> {
        let alpha = approach.max(R::zero());
        let radius = (c[RADIUS] * alpha).sqrt();
        let force = c[FOUR_THIRDS_MODULUS] * (radius * alpha);
        let root_radius = radius.sqrt();
        Normal {
            force,
            radius,
            stiffness: c[TWICE_MODULUS] * radius,
            root_stiffness: c[ROOT_MODULUS] * root_radius,
            root_radius,
            friction_load: force,
            touching: alpha.gt(R::zero()),
        }
    }

    /// `8/15 E* sqrt(R*) alpha^(5/2)`.
    fn energy(c: &[f64; LAW_CONSTANTS], approach: f64) -> f64 {
        let alpha = approach.max(0.0);
        0.4 * c[FOUR_THIRDS_MODULUS] * (c[RADIUS] * alpha).sqrt() * alpha * alpha
    }

    #[inline(always)]
    fn making_loss<R: Real>(_c: &[R; LAW_CONSTANTS]) -> R {
        R::zero()
    }

    #[inline(always)]
    fn breaking_loss<R: Real>(_c: &[R; LAW_CONSTANTS]) -> R {
        R::zero()
    }

    fn breaking_approach(_c: &[f64; LAW_CONSTANTS]) -> f64 {
        0.0
    }
}
