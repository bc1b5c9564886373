//! Elastic-plastic resistance to rolling and to twisting: [`super::ElasticPlasticRolling`] and the same spring with a slider about
//! the normal, with a coefficient of its own.
//!
//! With the relative spin about the normal `w_n = n.(w_i - w_j)` and the stiffness `k = 9/4 k_n (mu_t R*)^2`, k_n that of the normal
//! law at its present overlap:
//!
//! `M_n += k w_n dt`, then `|M_n| <= mu_t R* F` with the friction load F of the normal law (N without adhesion).
//!
//! The couple is `-M_n n` on grain i and `+M_n n` on j. Below the limit a dashpot adds `2 zeta_t (I_t k)^(1/2) w_n` to it, with
//! `1/I_t = 1/I_i + 1/I_j`; it is not part of the stored couple. A contact that resists twisting by friction over a contact
//! area of radius a has `mu_t R* = 2/3 mu a` for a uniform pressure, and `3 pi/16 mu a` for the pressure of Hertz.
//!
//! Spring, slider and energies are those of rolling; the spin about the normal is the same for every observer, and the couple about
//! the normal is a scalar that does not rotate with the contact.

use granum_simd::Real;

use super::ElasticPlasticRolling;
use super::elastic_plastic::{ElasticPlasticRollingConstants, ROLLING_DAMPING, ROLLING_FRICTION};
use super::slider::{slide, stored};
use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_MOMENT_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Moment, MomentLaw, Normal, RelativeSpin};
use crate::law_constants;

/// Rolling resistance by model C of Ai et al. (2011), and twisting resistance of the same kind.
#[derive(Clone, Copy, Debug)]
pub struct ElasticPlasticTwisting;

law_constants! {
    /// Constants of the elastic-plastic resistance to rolling and twisting for a pair.
    pub struct ElasticPlasticTwistingConstants<R> {
        /// Those of rolling; what counts as a tangential stiffness includes the twisting spring.
        pub rolling: ElasticPlasticRollingConstants<R>,
        /// `mu_t R*`, m.
        pub arm: R,
        /// `2 zeta_t I_t^(1/2)`: multiplied by the square root of the stiffness it gives the coefficient of the dashpot.
        pub dashpot: R,
    }
}

/// Column of the couple about the normal; it follows those of rolling.
const COUPLE: usize = ElasticPlasticRolling::HISTORY;
const STIFFNESS_BEFORE: usize = COUPLE + 1;

/// `9/4`, as for rolling.
const SHAPE: f64 = 2.25;
/// Inertia of a sphere about its centre over that about its contact: 2/5 over 7/5.
const ABOUT_CENTRE: f64 = 2.0 / 7.0;

impl MomentLaw for ElasticPlasticTwisting {
    type Constants<R: Real> = ElasticPlasticTwistingConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "elastic-plastic-twisting",
        label: "elastic-plastic rolling and twisting resistance",
        help: "elastic-plastic against rolling, and likewise against twisting, with a coefficient of its own",
        parameters: &[
            ROLLING_FRICTION,
            ROLLING_DAMPING,
            LawParameter {
                key: "twisting_friction",
                unit: Unit::NUMBER,
                default: 0.05,
                bounds: [0.0, 2.0],
                meaning: "Coefficient mu_t of twisting friction: the couple about the normal is at most mu_t R* N",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            LawParameter {
                key: "twisting_damping",
                unit: Unit::NUMBER,
                default: 0.3,
                bounds: [0.0, 1.0],
                meaning: "Fraction zeta_t of critical damping of the twisting spring below its limit",
                without_area: false,
                mixing: Mixing::Arithmetic,
            },
        ],
    };
    const HISTORY: usize = STIFFNESS_BEFORE + 1;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> ElasticPlasticTwistingConstants<f64> {
        let [friction, damping] = [parameters[2], parameters[3]];
        let arm = friction * pair.effective_radius;
        let rolling = ElasticPlasticRolling::prepare(pair, &parameters[..2]);
        // Grains that twist in phase oscillate at most as fast as with half of this stiffness against rolling.
        let share = arm / pair.smaller_radius;
        let step = rolling.step + 0.5 * SHAPE * share * share;
        ElasticPlasticTwistingConstants {
            rolling: ElasticPlasticRollingConstants { step, ..rolling },
            arm,
            dashpot: 2.0 * damping * (ABOUT_CENTRE * pair.rolling_inertia).sqrt(),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &ElasticPlasticTwistingConstants<R>,
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        let rolling = ElasticPlasticRolling::update(&c.rolling, normal, spin, dt, history, energies);
        let root = R::splat(SHAPE.sqrt()) * c.arm * normal.root_stiffness;
        let stiffness = root * root;
        let limit = c.arm * normal.friction_load;
        let before = history[STIFFNESS_BEFORE];
        let out = slide([history[COUPLE]], before, stiffness, limit, [dt * spin.twisting]);
        history[COUPLE] = out.couple[0];
        history[STIFFNESS_BEFORE] = stiffness;
        Moment {
            couple: [rolling.couple[0], rolling.couple[1], out.couple[0]],
            twisting_dashpot: (c.dashpot * root).keep(!out.at_limit),
            at_limit: rolling.at_limit | out.at_limit,
            work: rolling.work + out.work,
            loss: rolling.loss + out.loss,
            ..rolling
        }
    }

    fn energy(c: &ElasticPlasticTwistingConstants<f64>, history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        ElasticPlasticRolling::energy(&c.rolling, history)
            + stored([history[COUPLE]], history[STIFFNESS_BEFORE])
    }
}
