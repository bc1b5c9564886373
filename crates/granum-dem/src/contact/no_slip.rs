//! Tangential contact without micro-slip, the force rescaled when the contact shrinks (Thornton, Cummins and
//! Cleary 2013; Agnolin and Roux 2007).
//!
//! `T <- T a / a_old` where the contact radius a falls, then `T += 8 G* a ddelta`, then `|T| <= mu F` with the
//! friction load F of the normal law.

use granum_simd::Real;

use super::interaction::{add_scaled, dot, scale};
use super::{LAW_CONSTANTS, MAX_HISTORY, Normal, PairProperties, Tangential, TangentialLaw};

/// No-slip Mindlin with rescaling.
#[derive(Clone, Copy, Debug)]
pub struct NoSlip;

const EIGHT_MODULI: usize = 0;
const FRICTION: usize = 1;
const RADIUS_BEFORE: usize = 3;

impl TangentialLaw for NoSlip {
    const HISTORY: usize = 4;
    const VECTORS: usize = 1;

    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[EIGHT_MODULI] = 8.0 * pair.effective_shear_modulus;
        c[FRICTION] = pair.friction;
        c
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        _direction: [R; 3],
        increment: [R; 3],
        history: &mut [R; MAX_HISTORY],
    ) -> Tangential<R> {
        let tiny = R::splat(1e-300);
        let stiffness = c[EIGHT_MODULI] * normal.radius;
        let limit = c[FRICTION] * normal.friction_load;
        let before = history[RADIUS_BEFORE];
        let shrink = R::select(normal.radius.lt(before), normal.radius / before.max(tiny), R::splat(1.0));
        let kept = scale(shrink, [history[0], history[1], history[2]]);
        let trial = add_scaled(kept, stiffness, increment);
        let square = dot(trial, trial);
        let sliding = square.ge(limit * limit);
        let length = square.max(tiny).sqrt();
        let force = scale(R::select(sliding, limit / length, R::splat(1.0)), trial);
        history[..3].copy_from_slice(&force);
        history[RADIUS_BEFORE] = normal.radius;
        Tangential {
            force,
            stiffness,
            sliding,
            friction_loss: (limit * (length - limit) / stiffness.max(tiny)).keep(sliding).max(R::zero()),
        }
    }

    #[inline(always)]
    fn force<R: Real>(_direction: [R; 3], history: &[R; MAX_HISTORY]) -> [R; 3] {
        [history[0], history[1], history[2]]
    }
}
