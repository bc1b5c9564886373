//! A law of rolling with a parameter, constants, a history and an energy channel of its own: the spring and slider of Iwashita and
//! Oda (1998).
//!
//! The couple M grows by `k_r` times the angle of rolling, with `k_r = k_n R*^2`, up to `mu_r R* F`, F the friction load of the
//! normal law. It is remembered in the frame of the contact, and turns with it. What a contact gives up when its stiffness changes is
//! neither lost by rolling nor stored: it has a channel.

use granum::law::*;

#[derive(Clone, Copy)]
pub struct RollingSpring;

law_constants! {
    /// What is prepared for a pair.
    pub struct RollingSpringConstants<R> {
        /// `mu_r R*`, m.
        arm: R,
        /// `R*^2`, m2.
        area: R,
        /// `R*^2` over the square of the smaller radius.
        step: R,
    }
}

/// The channel of the energy that is given up when the stiffness changes.
const RELEASED: usize = 0;

/// What is remembered after the two components of the couple.
const STIFFNESS_BEFORE: usize = 2;

impl MomentLaw for RollingSpring {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "rolling-spring",
        "rolling spring",
        "a spring and a slider against rolling (Iwashita and Oda 1998)",
        &[LawParameter::new(
            "rolling_spring_friction",
            Unit::NUMBER,
            0.1,
            [0.0, 1.0],
            "Coefficient mu_r: the rolling couple is at most mu_r R* F",
        )],
    );
    type Constants<R: Real> = RollingSpringConstants<R>;
    const CHANNELS: &'static [EnergyChannel] = &[EnergyChannel::dissipated(
        "rolling_release_loss",
        "released by rolling springs",
        "energy that rolling springs give up where the stiffness of their contact changes",
    )];
    const HISTORY: usize = 3;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> RollingSpringConstants<f64> {
        RollingSpringConstants {
            arm: parameters[0] * pair.effective_radius,
            area: pair.effective_radius.powi(2),
            step: (pair.effective_radius / pair.smaller_radius).powi(2),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &RollingSpringConstants<R>,
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        let (one, half, tiny) = (R::splat(1.0), R::splat(0.5), R::splat(1e-200));
        let (stiffness, limit) = (c.area * normal.stiffness, c.arm * normal.friction_load);
        let (held, before) = ([history[0], history[1]], history[STIFFNESS_BEFORE]);
        // A contact that grows softer cannot hold what it held: it would make energy.
        let kept = (stiffness / before.max(tiny)).min(one);
        let turned = [dt * spin.rolling[0], dt * spin.rolling[1]];
        let carried = held.map(|component| kept * component);
        let trial = [0, 1].map(|a| carried[a] + stiffness * turned[a]);
        let square = dot(trial, trial);
        let at_limit = square.ge(limit * limit);
        let factor = R::select(at_limit, limit / square.sqrt().max(tiny), one);
        let couple = trial.map(|component| factor * component);
        [history[0], history[1]] = couple;
        history[STIFFNESS_BEFORE] = stiffness;
        let work = half * dot([held[0] + couple[0], held[1] + couple[1]], turned);
        let stored = |couple, stiffness: R| half * dot(couple, couple) / stiffness.max(tiny);
        let slid = half * dot([carried[0] + couple[0], carried[1] + couple[1]], turned)
            - (stored(couple, stiffness) - stored(carried, stiffness));
        energies[RELEASED] = work - (stored(couple, stiffness) - stored(held, before)) - slid;
        Moment {
            couple: [couple[0], couple[1], R::zero()],
            at_limit,
            // What is in the channel is accounted for there.
            work: work - energies[RELEASED],
            loss: slid,
            step_stiffness: c.step * normal.stiffness,
            ..Moment::none()
        }
    }

    fn energy(_: &RollingSpringConstants<f64>, history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        let couple = [history[0], history[1]];
        0.5 * dot(couple, couple) / history[STIFFNESS_BEFORE].max(1e-200)
    }
}

#[inline(always)]
fn dot<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0] * b[0] + a[1] * b[1]
}
