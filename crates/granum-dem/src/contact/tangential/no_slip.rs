//! Tangential contact without micro-slip, with a force that is rescaled when the contact shrinks (Thornton, Cummins and
//! Cleary 2013; Agnolin and Roux 2007).
//!
//! `T <- T a / a_old` where the contact radius a decreases, then `T += 8 G* a ddelta`, then `|T| <= mu F` with the friction
//! load F of the normal law.
//!
//! The energy that the contact spring stored and cannot store at the changed radius is lost: with `r = a / a_old`, this is
//! `T^2 / 16 G* a_old` times `1 - r` where the contact shrinks, and times `1 - 1/r` where it grows.
//!
//! With a normal law without a contact area the stiffness is `k_t = (k_t/k_n) k_n`, with the ratio as a parameter, and the
//! law is the linear spring with a slider of Cundall and Strack (1979).

use granum_simd::{Mask, Real};

use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalTraits, Tangential, TangentialLaw};
use crate::law_constants;

/// No-slip Mindlin with rescaling.
#[derive(Clone, Copy, Debug)]
pub struct NoSlip;

law_constants! {
    /// Constants of the no-slip law for a pair.
    pub struct NoSlipConstants<R> {
        /// Ratio of the tangential stiffness to the tangential measure of the normal law: `8 G*` or `k_t/k_n`.
        pub coefficient: R,
        /// `mu`.
        pub friction: R,
        /// Square root of the coefficient.
        pub root_coefficient: R,
        /// The coefficient for the time step.
        pub step_coefficient: R,
    }
}

/// The history column that follows the force: the tangential measure before the step.
const MEASURE_BEFORE: usize = 2;

/// Below this ratio of tangential to normal stiffness, spinning is no longer the fastest mode of oscillation of the grains.
const LEAST_STEP_RATIO: f64 = 1.0 / 3.0;

impl TangentialLaw for NoSlip {
    type Constants<R: Real> = NoSlipConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "no-slip",
        label: "no-slip Mindlin",
        help: "no-slip Mindlin; with normal = \"hooke\" a linear spring and a slider",
        parameters: &[LawParameter {
            key: "tangential_stiffness_ratio",
            unit: Unit::NUMBER,
            // Gives equal half periods of the normal and the tangential motion of solid spheres.
            default: 2.0 / 7.0,
            bounds: [0.0, 1.0],
            meaning: "Tangential stiffness over the normal stiffness, k_t/k_n, for a normal law without contact area",
            without_area: true,
            mixing: Mixing::Arithmetic,
        }],
    };
    const HISTORY: usize = 3;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, normal: &NormalTraits, parameters: &[f64]) -> NoSlipConstants<f64> {
        let [coefficient, step] = if normal.contact_area {
            [8.0 * pair.effective_shear_modulus; 2]
        } else {
            [parameters[0], parameters[0].max(LEAST_STEP_RATIO)]
        };
        NoSlipConstants {
            coefficient,
            friction: pair.friction,
            root_coefficient: coefficient.sqrt(),
            step_coefficient: step,
        }
    }

    #[inline(always)]
    fn stiffness<R: Real>(c: &NoSlipConstants<R>, normal: &Normal<R>) -> R {
        c.coefficient * normal.tangential_measure
    }

    #[inline(always)]
    fn step_stiffness<R: Real>(c: &NoSlipConstants<R>, normal: &Normal<R>) -> R {
        c.step_coefficient * normal.tangential_measure
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &NoSlipConstants<R>,
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Tangential<R> {
        let (tiny, one) = (R::splat(1e-200), R::splat(1.0));
        let stiffness = Self::stiffness(c, normal);
        let limit = c.friction * normal.friction_load;
        let before = history[MEASURE_BEFORE];
        let held = [history[0], history[1]];
        let ratio = normal.tangential_measure / before.max(tiny);
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
        history[MEASURE_BEFORE] = normal.tangential_measure;
        let compliance = one / stiffness.max(tiny);
        let slipped = ((length - limit) * compliance).max(R::zero()).keep(sliding);
        // Mean force in the direction of slip during the step.
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
            root_stiffness: c.root_coefficient * normal.root_tangential_measure,
            sliding,
            friction_loss: slipped * pull,
            micro_slip_loss: lost,
            discards: R::Mask::splat(false),
        }
    }
}
