//! Elastic-plastic rolling resistance with a dashpot: model C of Ai, Chen, Rotter and Ooi (2011), Powder Technology 206,
//! 269-282.
//!
//! With the relative spin in the contact plane `w = (1 - n n).(w_i - w_j)` and the stiffness `k = 9/4 k_n (mu_r R*)^2`,
//! where k_n is the stiffness of the normal law at the present overlap:
//!
//! `M += k w dt`, then `|M| <= mu_r R* F` with the friction load F of the normal law (N without adhesion).
//!
//! The couple is `-M` on grain i and `+M` on j. Below the limit a dashpot adds `2 zeta_r (I_r k)^(1/2) w` to M; at the limit
//! there is none (f = 0 in the paper). The dashpot is not a part of the stored couple. `1/I_r = sum of 1/(I + m R^2)`.
//!
//! The relative spin is the same for every observer and work-conjugate to opposite couples for any radii; multiplied by R*
//! it is the rolling velocity of Luding (2008), Granular Matter 10, 235, and of Wang, Alonso-Marroquin, Xue and Xie (2015),
//! Particuology 18, 35. The couple is stored in the frame of the contact and rotates with it.
//!
//! Where k decreases, M decreases with it, so that unloading does not create energy. The couple stores `M^2 / 2k`; the part
//! of its work `(M_old + M) . w dt / 2` that is not stored is lost.

use granum_simd::Real;

use super::slider::{slide, stored};
use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_MOMENT_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Moment, MomentLaw, Normal, RelativeSpin};
use crate::law_constants;

/// Model C of Ai et al. (2011).
#[derive(Clone, Copy, Debug)]
pub struct ElasticPlasticRolling;

law_constants! {
    /// Constants of the elastic-plastic resistance to rolling for a pair.
    pub struct ElasticPlasticRollingConstants<R> {
        /// `mu_r R*`, m.
        pub arm: R,
        /// `9/4 (mu_r R*)^2`, m2: multiplied by the normal stiffness it gives k.
        pub stiffness_area: R,
        /// `3 zeta_r mu_r R* I_r^(1/2)`: multiplied by the square root of the normal stiffness it gives the coefficient of
        /// the dashpot.
        pub dashpot: R,
        /// `9/4 (mu_r R*)^2 / R^2` with the smaller radius R: multiplied by the normal stiffness it counts as a tangential
        /// stiffness.
        pub step: R,
    }
}

/// The history column that follows the couple: the stiffness before the step.
const STIFFNESS_BEFORE: usize = 2;

/// `contact.rolling_friction`.
pub(super) const ROLLING_FRICTION: LawParameter = LawParameter {
    key: "rolling_friction",
    unit: Unit::NUMBER,
    default: 0.1,
    bounds: [0.0, 2.0],
    meaning: "Coefficient mu_r of rolling friction: the rolling couple is at most mu_r R* N",
    without_area: false,
    mixing: Mixing::Geometric,
};
/// `contact.rolling_damping`.
pub(super) const ROLLING_DAMPING: LawParameter = LawParameter {
    key: "rolling_damping",
    unit: Unit::NUMBER,
    default: 0.3,
    bounds: [0.0, 1.0],
    meaning: "Fraction zeta_r of critical damping of the rolling spring below its limit",
    without_area: false,
    mixing: Mixing::Arithmetic,
};

impl MomentLaw for ElasticPlasticRolling {
    type Constants<R: Real> = ElasticPlasticRollingConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "elastic-plastic",
        label: "elastic-plastic rolling resistance",
        help: "a spring, a slider and a dashpot against rolling: model C of Ai et al. 2011",
        parameters: &[ROLLING_FRICTION, ROLLING_DAMPING],
    };
    const HISTORY: usize = 3;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> ElasticPlasticRollingConstants<f64> {
        let [friction, damping] = [parameters[0], parameters[1]];
        let arm = friction * pair.effective_radius;
        let stiffness_area = 2.25 * arm * arm;
        ElasticPlasticRollingConstants {
            arm,
            stiffness_area,
            dashpot: 3.0 * damping * arm * pair.rolling_inertia.sqrt(),
            step: stiffness_area / (pair.smaller_radius * pair.smaller_radius),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &ElasticPlasticRollingConstants<R>,
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        let stiffness = c.stiffness_area * normal.stiffness;
        let limit = c.arm * normal.friction_load;
        let turned = [dt * spin.rolling[0], dt * spin.rolling[1]];
        let held = [history[0], history[1]];
        let out = slide(held, history[STIFFNESS_BEFORE], stiffness, limit, turned);
        [history[0], history[1]] = out.couple;
        history[STIFFNESS_BEFORE] = stiffness;
        Moment {
            couple: [out.couple[0], out.couple[1], R::zero()],
            dashpot: (c.dashpot * normal.root_stiffness).keep(!out.at_limit),
            twisting_dashpot: R::zero(),
            at_limit: out.at_limit,
            work: out.work,
            loss: out.loss,
            step_stiffness: c.step * normal.stiffness,
        }
    }

    /// `M^2 / 2 k`.
    fn energy(_c: &ElasticPlasticRollingConstants<f64>, history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        stored([history[0], history[1]], history[STIFFNESS_BEFORE])
    }
}
