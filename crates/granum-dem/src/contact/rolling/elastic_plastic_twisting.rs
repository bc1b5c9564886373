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
use super::elastic_plastic::{ROLLING_DAMPING, ROLLING_FRICTION};
use super::slider::{slide, stored};
use crate::contact::description::{Description, Mixing, Parameter, Unit};
use crate::contact::law::{Moment, MomentLaw, Normal, RelativeSpin};
use crate::contact::limits::{LAW_CONSTANTS, MAX_MOMENT_HISTORY};
use crate::contact::pair_properties::PairProperties;

/// Rolling resistance by model C of Ai et al. (2011), and twisting resistance of the same kind.
#[derive(Clone, Copy, Debug)]
pub struct ElasticPlasticTwisting;

/// `mu_t R*`, m. It follows the constants of rolling.
const ARM: usize = 4;
/// `2 zeta_t I_t^(1/2)`: multiplied by the square root of the stiffness it gives the coefficient of the dashpot.
const DASHPOT: usize = 5;

/// Column of the couple about the normal; it follows those of rolling.
const COUPLE: usize = ElasticPlasticRolling::HISTORY;
const STIFFNESS_BEFORE: usize = COUPLE + 1;

/// `9/4`, as for rolling.
const SHAPE: f64 = 2.25;
/// Inertia of a sphere about its centre over that about its contact: 2/5 over 7/5.
const ABOUT_CENTRE: f64 = 2.0 / 7.0;

impl MomentLaw for ElasticPlasticTwisting {
    const DESCRIPTION: Description = Description {
        name: "elastic-plastic-twisting",
        label: "elastic-plastic rolling and twisting resistance",
        help: "elastic-plastic against rolling, and likewise against twisting, with a coefficient of its own",
        parameters: &[
            ROLLING_FRICTION,
            ROLLING_DAMPING,
            Parameter {
                key: "twisting_friction",
                unit: Unit::NUMBER,
                default: 0.05,
                bounds: [0.0, 2.0],
                meaning: "Coefficient mu_t of twisting friction: the couple about the normal is at most mu_t R* N",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            Parameter {
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

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        let [friction, damping] = [parameters[2], parameters[3]];
        let mut c = ElasticPlasticRolling::prepare(pair, &parameters[..2]);
        c[ARM] = friction * pair.effective_radius;
        c[DASHPOT] = 2.0 * damping * (ABOUT_CENTRE * pair.rolling_inertia).sqrt();
        // Grains that twist in phase oscillate at most as fast as with half of this stiffness against rolling.
        let arm = c[ARM] / pair.smaller_radius;
        c[ElasticPlasticRolling::STEP] += 0.5 * SHAPE * arm * arm;
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
        let rolling = ElasticPlasticRolling::update(c, normal, spin, dt, history);
        let root = R::splat(SHAPE.sqrt()) * c[ARM] * normal.root_stiffness;
        let stiffness = root * root;
        let limit = c[ARM] * normal.friction_load;
        let before = history[STIFFNESS_BEFORE];
        let out = slide([history[COUPLE]], before, stiffness, limit, [dt * spin.twisting]);
        history[COUPLE] = out.couple[0];
        history[STIFFNESS_BEFORE] = stiffness;
        Moment {
            couple: [rolling.couple[0], rolling.couple[1], out.couple[0]],
            twisting_dashpot: (c[DASHPOT] * root).keep(!out.at_limit),
            at_limit: rolling.at_limit | out.at_limit,
            work: rolling.work + out.work,
            loss: rolling.loss + out.loss,
            ..rolling
        }
    }

    fn energy(c: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        ElasticPlasticRolling::energy(c, history) + stored([history[COUPLE]], history[STIFFNESS_BEFORE])
    }
}
