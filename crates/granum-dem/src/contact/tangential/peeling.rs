//! Tangential contact of adhesive spheres that peel before they slip (Savkoor and Briggs 1977), combined with the
//! Mindlin-Deresiewicz law as by Thornton and Yin (1991). For the normal law of Johnson, Kendall and Roberts.
//!
//! With `N_1 = 4 E* a^3 / 3 R*` of the normal law and `D = N_1 - (N + 2 N_c)`, which is `(4 N N_c + 4 N_c^2)^(1/2)` on the
//! stable branch:
//!
//! - *not yet peeled*: the tangential force shrinks the contact,
//!   `a^3 = 3 R* (N + 2 N_c + (D^2 - T^2 E*/4 G*)^(1/2)) / 4 E*`, and there is no slip, `T += 8 G* a ddelta`. It peels at
//!   `T_c = 2 |D| (G*/E*)^(1/2)`.
//! - *at the end of peeling*: `a^3 = 3 R* (N + 2 N_c) / 4 E*`. With `T_c` at or above the sliding force `T_s = mu F` the
//!   force drops to `T_s`: the contact slides. With `T_c` below it, the force is held at `T_c` as long as the
//!   Mindlin-Deresiewicz loading curve of that contact gives less at the accumulated displacement.
//! - *peeled*: Mindlin-Deresiewicz with that radius and the limit `T_s`, until the contact breaks. A reversal during the
//!   hold leads to this stage at once.
//!
//! `F` is the friction load of the normal law (Thornton 1991): `N + 2 N_c` above `-0.3 N_c`.

use granum_simd::vectors::{add_scaled, dot, select};
use granum_simd::{Real, cbrt};

use super::mindlin_deresiewicz::{
    MindlinDeresiewicz, MindlinDeresiewiczConstants, NOTHING, Outcome, ROUNDING, State, advance, energy,
    excess, square, state_of,
};
use crate::contact::law::description::LawDescription;
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalTraits, Tangential, TangentialLaw};
use crate::law_constants;

/// Savkoor and Briggs (1977), then Mindlin and Deresiewicz (1953).
#[derive(Clone, Copy, Debug)]
pub struct Peeling;

law_constants! {
    /// Constants of contacts that peel before they slip, for a pair.
    pub struct PeelingConstants<R> {
        /// Those of the peeled contact.
        pub peeled: MindlinDeresiewiczConstants<R>,
        /// `4 E* / 3 R*`: multiplied by a^3 it gives a load.
        pub load_of_cube: R,
        /// `2 N_c`, N.
        pub twice_pull_off: R,
        /// `E* / 4 G*`.
        pub compliance_ratio: R,
    }
}

/// Until the contact has peeled, the column of the turning point holds the accumulated displacement, m.
const DISPLACEMENT: usize = 2;
const STAGE: usize = 6;
const LOAD: usize = 7;
/// 0 not peeled, 1 held at the peeling force, 2 peeled.
const STATUS: usize = 8;
const TINY: f64 = 1e-200;

/// Force of the Mindlin-Deresiewicz loading curve at a displacement, N.
#[inline(always)]
fn loading_curve<R: Real>(displacement: R, stiffness: R, limit: R) -> R {
    let one = R::splat(1.0);
    // delta / C with C = 3 mu N / 16 G* a = 3/2 limit / stiffness.
    let share = displacement * stiffness * R::splat(2.0 / 3.0) / limit.max(R::splat(TINY));
    let rest = (one - share).max(R::zero());
    limit * (one - rest * rest.sqrt())
}

impl TangentialLaw for Peeling {
    type Constants<R: Real> = PeelingConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "peeling",
        label: "Savkoor–Briggs peeling, then Mindlin–Deresiewicz",
        help: "Mindlin-Deresiewicz after Savkoor-Briggs peeling; needs normal = \"jkr\"",
        parameters: &[],
    };
    const HISTORY: usize = 9;
    const PLANE_VECTORS: usize = 3;
    const DISCARDS: bool = true;

    fn goes_with(normal: &NormalTraits) -> Result<(), &'static str> {
        if normal.name == "jkr" {
            Ok(())
        } else {
            Err("needs adhesive contacts of the JKR theory: nothing peels without adhesion")
        }
    }

    fn prepare(pair: &PairProperties, normal: &NormalTraits, parameters: &[f64]) -> PeelingConstants<f64> {
        PeelingConstants {
            peeled: MindlinDeresiewicz::prepare(pair, normal, parameters),
            load_of_cube: 4.0 / 3.0 * pair.effective_modulus / pair.effective_radius,
            twice_pull_off: 3.0 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius,
            compliance_ratio: 0.25 * pair.effective_modulus / pair.effective_shear_modulus,
        }
    }

    #[inline(always)]
    fn stiffness<R: Real>(c: &PeelingConstants<R>, normal: &Normal<R>) -> R {
        MindlinDeresiewicz::stiffness(&c.peeled, normal)
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &PeelingConstants<R>,
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Tangential<R> {
        let (zero, one, two, tiny) = (R::zero(), R::splat(1.0), R::splat(2.0), R::splat(TINY));
        let force = [history[0], history[1]];
        let limit = c.peeled.friction * normal.friction_load;
        let fresh = history[STATUS].lt(R::splat(0.5));
        let held = history[STATUS].eq(one);

        // Radius of the contact: during peeling reduced by the force, afterwards that of N + 2 N_c.
        let cube = normal.radius * normal.radius * normal.radius;
        let core = normal.force + c.twice_pull_off;
        let rim = c.load_of_cube.mul_add(cube, -core);
        let rim_square = rim * rim;
        let reduced = square(force).mul_add(-c.compliance_ratio, rim_square).max(zero).sqrt();
        let signed = R::select(rim.lt(zero), -reduced, reduced);
        let radius = cbrt(((core + signed.keep(fresh)) / c.load_of_cube).max(zero));
        let stiffness = c.peeled.eight_moduli * radius;
        let root_stiffness = c.peeled.root_eight_moduli * radius.sqrt();

        // Peeling: no slip up to T_c, then the force drops or is held.
        let trial = add_scaled(force, stiffness, increment);
        let trial_length = square(trial).sqrt();
        let critical = (rim_square / c.compliance_ratio.max(tiny)).sqrt();
        let gone = add_scaled([history[DISPLACEMENT], history[DISPLACEMENT + 1]], one, increment);
        let peels = trial_length.ge(critical);
        let peeling = fresh & !peels;
        // A step back that is rounding is no reversal.
        let change = (critical - square(force).sqrt()).abs();
        let least = R::splat(ROUNDING).mul_add(change, R::splat(NOTHING) * critical);
        let back = stiffness * dot(trial, increment);
        let backward = back.lt(zero) & (back * back).gt(least * least * (trial_length * trial_length));
        let low = critical.lt(limit);
        let behind = loading_curve(square(gone).sqrt(), stiffness, limit).lt(critical);
        let holds = ((fresh & peels) | (held & !backward)) & low & behind;
        let drops = ((fresh & peels) | (held & !backward)) & !low;
        let reached = critical.min(limit) / trial_length.max(tiny);
        let factor = R::select(peeling, one, reached);
        let stuck = [trial[0] * factor, trial[1] * factor];

        // Peeled: Mindlin-Deresiewicz. A contact that leaves the hold starts there on the loading curve.
        let old = !(fresh | held);
        let mut state = State {
            force,
            turning: select::<R, 2>(old, [history[2], history[3]], [zero; 2]),
            returning: select::<R, 2>(old, [history[4], history[5]], [zero; 2]),
            stage: history[STAGE].keep(old),
        };
        let Outcome { sliding, friction_loss, micro_slip_loss, discards } =
            advance(&mut state, increment, stiffness, limit, c.peeled.friction * history[LOAD]);

        let before = peeling | holds | drops;
        let force = select::<R, 2>(before, stuck, state.force);
        let turning = select::<R, 2>(peeling | holds, gone, state.turning);
        [history[0], history[1]] = force;
        [history[2], history[3]] = [turning[0].keep(!drops), turning[1].keep(!drops)];
        [history[4], history[5]] = [state.returning[0].keep(!before), state.returning[1].keep(!before)];
        history[STAGE] = state.stage.keep(!before);
        history[LOAD] = normal.friction_load;
        history[STATUS] = R::select(peeling, zero, R::select(holds, one, two));
        let sliding = drops | (sliding & !before);
        let dropped = limit * ((trial_length - limit) / stiffness.max(tiny)).max(zero);
        Tangential {
            force,
            stiffness,
            root_stiffness,
            sliding,
            friction_loss: R::select(drops, dropped, friction_loss.keep(!before)),
            micro_slip_loss: micro_slip_loss.keep(!before),
            discards: discards & !before,
        }
    }

    #[inline(always)]
    fn discarded<R: Real>(c: &PeelingConstants<R>, stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        excess(&state_of(history), stiffness, c.peeled.friction * history[LOAD])
    }

    /// Once peeled, the energy is that of Mindlin and Deresiewicz with the radius of `N + 2 N_c`.
    #[inline(always)]
    fn energy<R: Real>(c: &PeelingConstants<R>, stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        let load = history[LOAD];
        let before = history[STATUS].lt(R::splat(1.5));
        let spring = R::splat(0.5) * square([history[0], history[1]]) / stiffness;
        let own = c.peeled.eight_moduli * cbrt((load / c.load_of_cube).max(R::zero()));
        let compliance = R::splat(1.0) / own.max(R::splat(TINY));
        let peeled = energy(&state_of(history), compliance, c.peeled.friction * load);
        R::select(before, spring.keep(stiffness.gt(R::zero())), peeled)
    }
}
