//! Tangential contact without micro-slip, the force rescaled when the contact shrinks (Thornton, Cummins and
//! Cleary 2013; Agnolin and Roux 2007).
//!
//! `T <- T a / a_old` where the contact radius a falls, then `T += 8 G* a ddelta`, then `|T| <= mu F` with the
//! friction load F of the normal law.
//!
//! What the spring of the contact stored and a changed radius no longer holds is lost: with `r = a / a_old`,
//! `T^2 / 16 G* a_old` times `1 - r` where the contact shrinks, times `1 - 1/r` where it grows.

use granum_simd::{Mask, Real};

use super::{LAW_CONSTANTS, MAX_HISTORY, Normal, PairProperties, Tangential, TangentialLaw};

/// No-slip Mindlin with rescaling.
#[derive(Clone, Copy, Debug)]
pub struct NoSlip;

const EIGHT_MODULI: usize = 0;
const FRICTION: usize = 1;
const ROOT_MODULI: usize = 2;
const RADIUS_BEFORE: usize = 2;

impl TangentialLaw for NoSlip {
    const HISTORY: usize = 3;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[EIGHT_MODULI] = 8.0 * pair.effective_shear_modulus;
        c[FRICTION] = pair.friction;
        c[ROOT_MODULI] = c[EIGHT_MODULI].sqrt();
        c
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
    ) -> Tangential<R> {
        let (tiny, one) = (R::splat(1e-200), R::splat(1.0));
        let stiffness = c[EIGHT_MODULI] * normal.radius;
        let limit = c[FRICTION] * normal.friction_load;
        let before = history[RADIUS_BEFORE];
        let held = [history[0], history[1]];
        let ratio = normal.radius / before.max(tiny);
        let shrink = ratio.min(one);
        let trial = [
            stiffness.mul_add(increment[0], shrink * held[0]),
            stiffness.mul_add(increment[1], shrink * held[1]),
        ];
        let square = trial[0].mul_add(trial[0], trial[1] * trial[1]);
        let sliding = square.ge(limit * limit);
        let length = square.sqrt();
        let factor = R::select(sliding, limit / length.max(tiny), one);
        let force = [factor * trial[0], factor * trial[1]];
        [history[0], history[1]] = force;
        history[RADIUS_BEFORE] = normal.radius;
        let compliance = one / stiffness.max(tiny);
        let slipped = ((length - limit) * compliance).max(R::zero()).keep(sliding);
        // Mean force along the slip in the step.
        let along = (held[0].mul_add(trial[0], held[1] * trial[1])) * shrink / length.max(tiny);
        let pull = R::splat(0.5) * (limit + along).max(R::zero());
        // Twice the energy before the step: T^2 / k_old = ratio T^2 / k.
        let stored = ratio * compliance * held[0].mul_add(held[0], held[1] * held[1]);
        let dropped = (one - shrink) * held[0].mul_add(increment[0], held[1] * increment[1]);
        let kept = shrink.min(one / ratio.max(tiny));
        let lost = R::splat(0.5) * (one - kept).mul_add(stored, dropped);
        Tangential {
            force,
            stiffness,
            root_stiffness: c[ROOT_MODULI] * normal.root_radius,
            sliding,
            friction_loss: slipped * pull,
            micro_slip_loss: lost,
            forgets: R::Mask::splat(false),
        }
    }
}
