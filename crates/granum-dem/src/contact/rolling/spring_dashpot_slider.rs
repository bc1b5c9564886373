//! Spring, dashpot and slider against rolling, with constants of their own: Luding (2008), Granular Matter 10, 235-246, in the form of
//! `rolling sds` of LAMMPS.
//!
//! With the relative spin in the contact plane `w = (1 - n n).(w_i - w_j)` and the rolling velocity `v = R* w`:
//!
//! `xi += v dt`, `F = k_r xi + gamma_r v`; where `|F| > mu_r N`, F is reduced to `mu_r N` in its direction, and
//! `xi = (F - gamma_r v) / k_r`,
//!
//! with the friction load of the normal law for N. The couple is `-R* F` on grain i and `+R* F` on j. Unlike in the elastic-plastic law,
//! k_r is a constant of the material, which does not grow with the normal force, and the limit holds for the sum of spring and dashpot.
//!
//! The rolling displacement xi lies in the contact plane, is stored in the frame of the contact, and rotates with it. As the relative spin,
//! it changes its sign when the grains of a pair change roles.
//!
//! The spring stores `k_r xi^2 / 2`; the part of its work `k_r (xi_old + xi) . v dt / 2` that is not stored is the loss, and the
//! dashpot loses `gamma_r v^2` besides. At the limit this rule takes from the spring what the dashpot adds to the couple. Where the dashpot alone
//! exceeds the limit it loads the spring against the motion, so that the loss of the slider is negative there.

use granum_simd::Real;
use granum_simd::vectors::dot;

use super::elastic_plastic::ROLLING_FRICTION;
use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_MOMENT_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Moment, MomentLaw, Normal, RelativeSpin};
use crate::law_constants;

/// The spring-dashpot-slider of Luding (2008).
#[derive(Clone, Copy, Debug)]
pub struct SpringDashpotSlider;

law_constants! {
    /// Constants of the spring, dashpot and slider against rolling for a pair.
    pub struct SpringDashpotSliderConstants<R> {
        /// `k_r`, N/m.
        pub stiffness: R,
        /// `1 / k_r`, m/N.
        pub compliance: R,
        /// `gamma_r`, N s/m.
        pub viscosity: R,
        /// `mu_r`.
        pub friction: R,
        /// `R*`, m.
        pub effective_radius: R,
        /// What counts as a tangential stiffness for the time step, N/m: of the spring, and of a spring with the frequency
        /// `gamma_r R*^2 / I_r`, at which the dashpot damps.
        pub step: R,
    }
}

impl MomentLaw for SpringDashpotSlider {
    type Constants<R: Real> = SpringDashpotSliderConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "spring-dashpot-slider",
        label: "spring-dashpot-slider rolling resistance",
        help: "a spring of constant stiffness and a dashpot with a slider against rolling: Luding 2008, as rolling sds in LAMMPS",
        parameters: &[
            ROLLING_FRICTION,
            LawParameter {
                key: "rolling_stiffness",
                unit: Unit::STIFFNESS,
                default: 1e3,
                bounds: [1e-3, 1e10],
                meaning: "Stiffness k_r of the rolling spring of every contact, relative to the displacement R* times the angle of rolling",
                without_area: false,
                mixing: Mixing::Harmonic,
            },
            LawParameter {
                key: "rolling_viscosity",
                unit: Unit { symbol: "N s/m", powers: [1, 0, -1] },
                default: 1e-3,
                bounds: [0.0, 1e6],
                meaning: "Coefficient gamma_r of the rolling dashpot of every contact, relative to R* times the rate of rolling",
                without_area: false,
                mixing: Mixing::Harmonic,
            },
        ],
    };
    const HISTORY: usize = 2;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> SpringDashpotSliderConstants<f64> {
        let [friction, stiffness, viscosity] = [parameters[0], parameters[1], parameters[2]];
        let square = pair.effective_radius * pair.effective_radius;
        let [spring, dashpot] = [square * stiffness, square * viscosity];
        let both = spring + dashpot * dashpot / pair.rolling_inertia;
        SpringDashpotSliderConstants {
            stiffness,
            compliance: 1.0 / stiffness,
            viscosity,
            friction,
            effective_radius: pair.effective_radius,
            step: both / (pair.smaller_radius * pair.smaller_radius),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &SpringDashpotSliderConstants<R>,
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        let (one, half, tiny) = (R::splat(1.0), R::splat(0.5), R::splat(1e-200));
        let limit = c.friction * normal.friction_load;
        let before = [history[0], history[1]];
        let velocity = [c.effective_radius * spin.rolling[0], c.effective_radius * spin.rolling[1]];
        let way = [dt * velocity[0], dt * velocity[1]];
        let (mut free, mut dashpot, mut force) = (before, before, before);
        for k in 0..2 {
            free[k] = before[k] + way[k];
            dashpot[k] = c.viscosity * velocity[k];
            force[k] = c.stiffness.mul_add(free[k], dashpot[k]);
        }
        let square = dot(force, force);
        let at_limit = square.gt(limit * limit);
        let factor = R::select(at_limit, limit / square.sqrt().max(tiny), one);
        let mut now = before;
        for k in 0..2 {
            let reduced = c.compliance * factor.mul_add(force[k], -dashpot[k]);
            now[k] = R::select(at_limit, reduced, free[k]).keep(normal.touching);
        }
        [history[0], history[1]] = now;
        let half_spring = half * c.stiffness;
        let work = half_spring * dot([before[0] + now[0], before[1] + now[1]], way);
        let gained = half_spring * (dot(now, now) - dot(before, before));
        let lever = c.stiffness * c.effective_radius;
        Moment {
            couple: [lever * now[0], lever * now[1], R::zero()],
            dashpot: c.viscosity * (c.effective_radius * c.effective_radius),
            twisting_dashpot: R::zero(),
            at_limit,
            work,
            loss: work - gained,
            step_stiffness: c.step,
        }
    }

    /// `k_r xi^2 / 2`.
    fn energy(c: &SpringDashpotSliderConstants<f64>, history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        let xi = [history[0], history[1]];
        0.5 * c.stiffness * dot(xi, xi)
    }
}
