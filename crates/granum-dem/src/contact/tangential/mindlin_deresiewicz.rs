//! Tangential contact with micro-slip and turning points: the incremental law of Mindlin and Deresiewicz (1953) as used by
//! Thornton and Randall (1988) and Thornton and Yin (1991), in a vector form for three dimensions.
//!
//! A loading curve starts from zero (stage 0), an unloading curve from the turning point `P` (stage 1), a reloading curve
//! from `Q` (stage 2). With `S` the force measured from the start of the present curve, `e = S / |S|`, `c = 1` on stage 0
//! and 2 otherwise, the limit `L = mu F` (F the friction load of the normal law) and its step `dL`:
//!
//! `theta^3 = 1 - (|S| + c dL) / (c L)` in `[0, 1]`, and `theta = 1` where `dL > 0` and `8 G* a |ddelta| < dL`,
//!
//! `T += 8 G* a [theta (e.ddelta) e + (ddelta - (e.ddelta) e)] + (1 - theta) dL e`.
//!
//! A step against `S` makes a turning point. A step back that is rounding, `8 G* a |e.ddelta| <= 1e-9 |dL| + 1e-12 L`, is none: the force
//! stays on its curve, which at held displacement is `dT = (1 - theta) dL` under a falling load and `dT = 0` under a growing one. A
//! turning point moves outwards with the limit (`P -= dL e` on stage 1,
//! `Q -= dL e` and `P += dL P/|P|` on stage 2), and is discarded when the force passes it: `|T - Q| >= |P - Q|` on stage 2,
//! `|T - P| >= 2 |P|` on stage 1. At a held displacement a falling limit can also take the start of the present curve to the force and
//! past it: then the curve before it goes on. At the limit the force slides: `T *= L / |T|`, stage 0.
//!
//! The energy is that of the equivalent array of springs (Popov and Hess 2015, ch. 5), which is exact in one dimension at
//! constant load. At the fraction x of the contact radius a spring has the limit `l(x) = 3/2 L (1 - x^2)`, and springs
//! beyond `theta` have slipped. A curve therefore adds the spring force `c e 3/2 L (1 - max(x, theta)^2)`, the stored energy
//! is the integral of the squared sum over `16 G* a`, and while slip spreads, the springs beyond theta lose their limit
//! times their slip: `L (1 - theta)^2 (1 + theta/2) (e.ddelta - dL / 8 G* a)`. A contact that grows without slip becomes
//! stiffer under its force: `T^2 dL / 6 L` over `8 G* a` is lost (`a^3` is proportional to L). With a discarded turning
//! point, the energy that the state stored beyond a loading curve to the same force is lost. Under a changing load the history
//! of the law, which contains forces only, does not determine all the energy that a contact stores (Elata and Berryman 1996); the
//! energy that the law creates or loses in this way is in no column.
//!
//! The law remembers two turning points. If a step reverses on a reloading curve while the force still opposes P, the present force
//! becomes P, and the springs of that state would carry more than their limit: up to 0.35 % of the work at the limit is then in no
//! column.

use granum_simd::vectors::{add_scaled, dot, select, subtract};
use granum_simd::{Real, cbrt};

use crate::contact::law::description::LawDescription;
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalTraits, Tangential, TangentialLaw};
use crate::law_constants;

/// Mindlin and Deresiewicz (1953), incremental, with two levels of turning points.
#[derive(Clone, Copy, Debug)]
pub struct MindlinDeresiewicz;

law_constants! {
    /// Constants of the law of Mindlin and Deresiewicz for a pair.
    pub struct MindlinDeresiewiczConstants<R> {
        /// `8 G*`, Pa: multiplied by the contact radius it gives the stiffness.
        pub eight_moduli: R,
        /// `mu`.
        pub friction: R,
        /// `(8 G*)^(1/2)`.
        pub root_eight_moduli: R,
    }
}

/// Columns of the history after the three vectors: the number of the curve, and the friction load of the last step.
const STAGE: usize = 6;
const LOAD: usize = 7;

/// Below this fraction of the limit, a force measured from the start of the present curve counts as zero.
pub(super) const NOTHING: f64 = 1e-12;
/// A step back that changes the force by less than this fraction of the change of the limit is rounding: displacements of one step are
/// differences of positions and velocities, which are known to some 1e-13.
pub(super) const ROUNDING: f64 = 1e-9;
/// On the loading curve the contact slides if the squared force is at least this fraction of the squared limit.
const AT_LIMIT: f64 = 1.0 - 1e-10;
/// Keeps reciprocals finite; values that it affects are multiplied by zero or discarded.
const TINY: f64 = 1e-200;

/// The history of the law, in the frame of the contact.
pub(super) struct State<R> {
    pub(super) force: [R; 2],
    pub(super) turning: [R; 2],
    pub(super) returning: [R; 2],
    pub(super) stage: R,
}

/// The result of a step apart from the new state.
pub(super) struct Outcome<R: Real> {
    pub(super) sliding: R::Mask,
    /// Energy lost by sliding at the limit, J.
    pub(super) friction_loss: R,
    /// Energy lost in the slip zone below the limit, J.
    pub(super) micro_slip_loss: R,
    /// Where a turning point was discarded.
    pub(super) discards: R::Mask,
}

/// Square of the length of a vector.
#[inline(always)]
pub(super) fn square<R: Real>(a: [R; 2]) -> R {
    dot(a, a)
}

/// One step of the law: `step` in m, `stiffness` 8 G* a, `limit` mu F after and before the step.
#[inline(always)]
pub(super) fn advance<R: Real>(
    state: &mut State<R>,
    step: [R; 2],
    stiffness: R,
    limit: R,
    limit_before: R,
) -> Outcome<R> {
    let (zero, one, two, tiny) = (R::zero(), R::splat(1.0), R::splat(2.0), R::splat(TINY));
    let growth = limit - limit_before;
    let before = state.force;

    // The force measured from the start of the present curve, and whether the step reverses it.
    let loading = state.stage.lt(R::splat(0.5));
    let unloading = state.stage.eq(one);
    let origin = select::<R, 2>(unloading, state.turning, state.returning);
    let origin = [origin[0].keep(!loading), origin[1].keep(!loading)];
    let counted = subtract(state.force, origin);
    let scale = R::splat(NOTHING) * limit_before;
    let counted_square = square(counted);
    let directed = counted_square.gt(scale * scale);
    // A step back below this is rounding.
    let least = R::splat(ROUNDING) * growth.abs() + scale;
    let back = stiffness * dot(counted, step);
    let turn = directed & back.lt(zero) & (back * back).gt(least * least * counted_square);
    let (returns, turns) = (turn & unloading, turn & !unloading);
    let remembered = !loading;
    state.returning = select::<R, 2>(returns, state.force, state.returning);
    state.turning = select::<R, 2>(turns, state.force, state.turning);
    let loading = loading & !turn;
    let unloading = (unloading & !turn) | turns;
    let reloading = !(loading | unloading);
    let curve_limit = R::select(loading, limit, limit + limit);
    let curve_before = R::select(loading, limit_before, limit_before + limit_before);

    // The direction in which slip spreads.
    let along = directed & !turn;
    let step_square = square(step);
    let vector = select::<R, 2>(along, counted, step);
    let vector_square = R::select(along, counted_square, step_square);
    let length = vector_square.sqrt();
    let inverse_length = length * (one / vector_square.max(tiny));
    let direction = [vector[0] * inverse_length, vector[1] * inverse_length];

    let cube = (curve_before - length.keep(along)) * (one / curve_limit.max(tiny));
    let elastic_step = stiffness * stiffness * step_square;
    let stick = growth.gt(zero) & elastic_step.lt(growth * growth);
    let theta = R::select(stick, one, cbrt(cube.max(zero).min(one)));
    let slip = (one - theta) * stiffness.mul_add(-dot(direction, step), growth);
    let elastic = add_scaled(state.force, stiffness, step);
    let force = add_scaled(elastic, slip, direction);

    // Turning points move outwards with the limit and are discarded when passed.
    let outward = growth / square(state.turning).sqrt().max(tiny);
    let moved = select::<R, 2>(reloading, state.turning, [-direction[0], -direction[1]]);
    let by = R::select(reloading, outward, growth).keep(!loading);
    state.turning = add_scaled(state.turning, by, moved);
    state.returning = add_scaled(state.returning, -growth.keep(reloading), direction);
    let base = select::<R, 2>(unloading, state.turning, state.returning);
    let other = select::<R, 2>(unloading, [zero; 2], state.returning);
    let span = square(subtract(state.turning, other));
    let span = R::select(unloading, R::splat(4.0) * span, span);
    let from_base = subtract(force, base);
    let passed = square(from_base).ge(span);
    // Where a falling limit has taken the start of the curve past the force at a held displacement, the curve before it goes on.
    let stays = (stiffness * stiffness * step_square).le(least * least);
    let overtaken = stays & !loading & dot(from_base, direction).le(zero) & growth.lt(zero);

    let trial_square = square(force);
    // A force that stays at the limit may be below it by a rounding error.
    let limit_square = limit * limit;
    let at_limit = loading & trial_square.ge(R::splat(AT_LIMIT) * limit_square);
    let sliding = at_limit | trial_square.ge(limit_square);
    let trial_inverse = trial_square.sqrt() * (one / trial_square.max(tiny));
    let factor = R::select(sliding, limit * trial_inverse, one);
    // The force that the step would have reached without slip, minus the limit, corresponds to the sliding distance.
    let excess = square(elastic).sqrt() - limit;
    let compliance = one / stiffness.max(tiny);
    let share = theta.mul_add(theta, theta).mul_add(R::splat(-0.5), one);
    // A contact that grows without slip carries its force with a stiffer spring.
    let stiffened = square(before) * (growth / limit.max(tiny)).keep(stick) * R::splat(1.0 / 6.0);
    let micro_slip_loss = (limit * share).mul_add(-slip, stiffened).max(zero).keep(!sliding) * compliance;
    state.force = [factor * force[0], factor * force[1]];
    let leaves = loading | passed | sliding | (overtaken & unloading);
    state.stage = R::select(unloading | overtaken, one, two).keep(!leaves);
    let discards = remembered & (leaves | turns);
    // The mean force in the direction of slip during the step.
    let pull = R::splat(0.5) * dot(before, force).mul_add(trial_inverse, limit);
    let friction_loss = (excess * compliance * pull).max(zero).keep(sliding);
    Outcome { sliding, friction_loss, micro_slip_loss, discards }
}

/// Stored energy of a state, J, for a contact with the given compliance, the reciprocal of the stiffness 8 G* a, m/N.
#[inline(always)]
pub(super) fn energy<R: Real>(state: &State<R>, compliance: R, limit: R) -> R {
    let (zero, one) = (R::zero(), R::splat(1.0));
    let (first, third) = (state.stage.lt(R::splat(0.5)), state.stage.gt(R::splat(1.5)));
    // Start and end of each curve; an absent curve ends where it starts.
    let turn = select::<R, 2>(first, state.force, state.turning);
    let end = select::<R, 2>(third, state.returning, state.force);
    let twice = limit + limit;
    let curves = [
        curve(turn, limit, one),
        curve(subtract(end, turn), twice, R::splat(2.0)),
        curve(subtract(state.force, end), twice, R::splat(2.0)),
    ];
    let mut sum = zero;
    for (k, (e, theta)) in curves.iter().enumerate() {
        sum = square(*e).mul_add(overlap(*theta, *theta), sum);
        for (other, phi) in &curves[k + 1..] {
            let both = overlap(theta.min(*phi), theta.max(*phi));
            sum = (both + both).mul_add(dot(*e, *other), sum);
        }
    }
    spring(compliance, limit) * sum
}

/// Energy that a state stores beyond a loading curve to the same force, J.
#[inline(always)]
pub(super) fn excess<R: Real>(state: &State<R>, stiffness: R, limit: R) -> R {
    let compliance = R::splat(1.0) / stiffness.max(R::splat(TINY));
    let (_, theta) = curve(state.force, limit, R::splat(1.0));
    energy(state, compliance, limit) - spring(compliance, limit) * overlap(theta, theta)
}

/// `L^2 / 2 k`, zero where the limit is zero.
#[inline(always)]
fn spring<R: Real>(compliance: R, limit: R) -> R {
    (R::splat(0.5) * limit * limit * compliance).keep(limit.gt(R::zero()))
}

/// Direction of a curve with the given limit, multiplied by `multiple`, and the fraction of the radius within which nothing
/// has slipped on it.
#[inline(always)]
fn curve<R: Real>(vector: [R; 2], limit: R, multiple: R) -> ([R; 2], R) {
    let (one, tiny) = (R::splat(1.0), R::splat(TINY));
    let length = square(vector).sqrt();
    let scale = multiple / length.max(tiny);
    let cube = (one - length / limit.max(tiny)).max(R::zero());
    ([vector[0] * scale, vector[1] * scale], cbrt(cube))
}

/// Integral over x from 0 to 1 of `9/4 (1 - max(x, a)^2) (1 - max(x, b)^2)`, `a <= b`:
/// `6/5 - 3/2 b^3 + 3/10 b^5 - 3/2 a^3 (1 - b^2)`.
#[inline(always)]
fn overlap<R: Real>(a: R, b: R) -> R {
    let square = b * b;
    let high = square.mul_add(R::splat(0.3), R::splat(-1.5));
    let outer = (square * b).mul_add(high, R::splat(1.2));
    (a * a * a).mul_add(R::splat(1.5) * (square - R::splat(1.0)), outer)
}

/// The state stored in a history.
#[inline(always)]
pub(super) fn state_of<R: Real>(history: &[R; MAX_HISTORY]) -> State<R> {
    State {
        force: [history[0], history[1]],
        turning: [history[2], history[3]],
        returning: [history[4], history[5]],
        stage: history[STAGE],
    }
}

impl TangentialLaw for MindlinDeresiewicz {
    type Constants<R: Real> = MindlinDeresiewiczConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "mindlin-deresiewicz",
        label: "Mindlin–Deresiewicz",
        help: "incremental, with turning points: Mindlin and Deresiewicz 1953, Thornton and Yin 1991",
        parameters: &[],
    };
    const HISTORY: usize = 8;
    const PLANE_VECTORS: usize = 3;
    const DISCARDS: bool = true;

    fn goes_with(normal: &NormalTraits) -> Result<(), &'static str> {
        if normal.contact_area {
            Ok(())
        } else {
            Err("needs a normal law with a contact area, over which slip spreads")
        }
    }

    fn prepare(
        pair: &PairProperties,
        _normal: &NormalTraits,
        _parameters: &[f64],
    ) -> MindlinDeresiewiczConstants<f64> {
        let eight_moduli = 8.0 * pair.effective_shear_modulus;
        MindlinDeresiewiczConstants {
            eight_moduli,
            friction: pair.friction,
            root_eight_moduli: eight_moduli.sqrt(),
        }
    }

    #[inline(always)]
    fn stiffness<R: Real>(c: &MindlinDeresiewiczConstants<R>, normal: &Normal<R>) -> R {
        c.eight_moduli * normal.radius
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &MindlinDeresiewiczConstants<R>,
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Tangential<R> {
        let stiffness = Self::stiffness(c, normal);
        let limit = c.friction * normal.friction_load;
        let mut state = state_of(history);
        let outcome = advance(&mut state, increment, stiffness, limit, c.friction * history[LOAD]);
        [history[0], history[1]] = state.force;
        [history[2], history[3]] = state.turning;
        [history[4], history[5]] = state.returning;
        history[STAGE] = state.stage;
        history[LOAD] = normal.friction_load;
        Tangential {
            force: state.force,
            stiffness,
            root_stiffness: c.root_eight_moduli * normal.root_tangential_measure,
            sliding: outcome.sliding,
            friction_loss: outcome.friction_loss,
            micro_slip_loss: outcome.micro_slip_loss,
            discards: outcome.discards,
        }
    }

    #[inline(always)]
    fn discarded<R: Real>(c: &MindlinDeresiewiczConstants<R>, stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        excess(&state_of(history), stiffness, c.friction * history[LOAD])
    }

    #[inline(always)]
    fn energy<R: Real>(c: &MindlinDeresiewiczConstants<R>, stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        energy(&state_of(history), R::splat(1.0) / stiffness.max(R::splat(TINY)), c.friction * history[LOAD])
    }
}
