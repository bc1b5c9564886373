//! Elastic-plastic resistance to rolling with a dashpot: model C of Ai, Chen, Rotter and Ooi (2011), Powder Technology 206,
//! 269-282.
//!
//! With the relative spin in the contact plane `w = (1 - n n).(w_i - w_j)` and the stiffness `k = 9/4 k_n (mu_r R*)^2`, k_n that
//! of the normal law at its present overlap:
//!
//! `M += k w dt`, then `|M| <= mu_r R* F` with the friction load F of the normal law (N without adhesion).
//!
//! The couple is `-M` on grain i and `+M` on j. Below the limit a dashpot adds `2 zeta_r (I_r k)^(1/2) w` to M; at the limit there
//! is none (f = 0 in the paper). It is no part of the remembered couple. `1/I_r = sum of 1/(I + m R^2)`.
//!
//! The relative spin is the same for every observer and conjugate to opposite couples for any radii; multiplied by R* it is
//! the rolling velocity of Luding (2008), Granular Matter 10, 235, and of Wang, Alonso-Marroquin, Xue and Xie (2015),
//! Particuology 18, 35. The couple is remembered in the frame of the contact and turns with it.
//!
//! Where k falls, M falls with it, lest unloading makes energy. The couple stores `M^2 / 2k`; what its work
//! `(M_old + M) . w dt / 2` does not store is lost.

use granum_simd::Real;

use crate::contact::{
    Description, LAW_CONSTANTS, MAX_MOMENT_HISTORY, Moment, MomentLaw, Normal, PairProperties, Parameter,
    RelativeSpin, Unit,
};

/// Model C of Ai et al. (2011).
#[derive(Clone, Copy, Debug)]
pub struct ElasticPlasticRolling;

/// `mu_r R*`, m.
const ARM: usize = 0;
/// `9/4 (mu_r R*)^2`, m2: times the normal stiffness it is k.
const STIFFNESS_AREA: usize = 1;
/// `3 zeta_r mu_r R* I_r^(1/2)`: times the root of the normal stiffness it is the dashpot's coefficient.
const DASHPOT: usize = 2;
/// `9/4 (mu_r R*)^2 / R^2` with the smaller radius R: times the normal stiffness it counts as a tangential stiffness.
const STEP: usize = 3;

/// Columns of history after the couple.
const STIFFNESS_BEFORE: usize = 2;

const FRICTION: usize = 0;
const DAMPING: usize = 1;

impl MomentLaw for ElasticPlasticRolling {
    const DESCRIPTION: Description = Description {
        name: "elastic-plastic",
        label: "elastic-plastic rolling resistance",
        help: "a spring, a slider and a dashpot against rolling: model C of Ai et al. 2011",
        parameters: &[
            Parameter {
                key: "rolling_friction",
                unit: Unit::NUMBER,
                default: 0.1,
                bounds: [0.0, 2.0],
                meaning: "Coefficient mu_r of rolling friction: the rolling couple is at most mu_r R* N",
                without_area: false,
            },
            Parameter {
                key: "rolling_damping",
                unit: Unit::NUMBER,
                default: 0.3,
                bounds: [0.0, 1.0],
                meaning: "Fraction zeta_r of critical damping of the rolling spring below its limit",
                without_area: false,
            },
        ],
    };
    const HISTORY: usize = 3;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[ARM] = parameters[FRICTION] * pair.effective_radius;
        c[STIFFNESS_AREA] = 2.25 * c[ARM] * c[ARM];
        c[DASHPOT] = 3.0 * parameters[DAMPING] * c[ARM] * pair.rolling_inertia.sqrt();
        c[STEP] = c[STIFFNESS_AREA] / (pair.smaller_radius * pair.smaller_radius);
        c
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
    ) -> Moment<R> {
        let (zero, one, half, tiny) = (R::zero(), R::splat(1.0), R::splat(0.5), R::splat(1e-200));
        let stiffness = c[STIFFNESS_AREA] * normal.stiffness;
        let limit = c[ARM] * normal.friction_load;
        let (held, before) = ([history[0], history[1]], history[STIFFNESS_BEFORE]);
        let turned = [dt * spin.rolling[0], dt * spin.rolling[1]];
        let kept = (stiffness / before.max(tiny)).min(one);
        let trial =
            [stiffness.mul_add(turned[0], kept * held[0]), stiffness.mul_add(turned[1], kept * held[1])];
        let square = dot(trial, trial);
        let at_limit = square.ge(limit * limit);
        let factor = R::select(at_limit, limit / square.sqrt().max(tiny), one);
        let couple = [factor * trial[0], factor * trial[1]];
        [history[0], history[1]] = couple;
        history[STIFFNESS_BEFORE] = stiffness;
        let work = half * dot([held[0] + couple[0], held[1] + couple[1]], turned);
        let stored = |couple: [R; 2], stiffness: R| half * dot(couple, couple) / stiffness.max(tiny);
        // No couple, no energy: also where the stiffness is nothing.
        let gained = stored(couple, stiffness) - stored(held, before);
        Moment {
            couple: [couple[0], couple[1], zero],
            dashpot: (c[DASHPOT] * normal.root_stiffness).keep(!at_limit),
            at_limit,
            work,
            loss: work - gained,
            step_stiffness: c[STEP] * normal.stiffness,
        }
    }

    /// `M^2 / 2 k`.
    fn energy(_c: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        let stiffness = history[STIFFNESS_BEFORE];
        let couple = [history[0], history[1]];
        if stiffness > 0.0 { 0.5 * dot(couple, couple) / stiffness } else { 0.0 }
    }
}

#[inline(always)]
fn dot<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0].mul_add(b[0], a[1] * b[1])
}
