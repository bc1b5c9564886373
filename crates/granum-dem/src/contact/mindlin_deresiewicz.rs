//! Tangential contact with micro-slip and turning points: the incremental law of Mindlin and Deresiewicz (1953) as Thornton
//! and Randall (1988) and Thornton and Yin (1991) use it, in a vector form for three dimensions.
//!
//! A loading curve starts from zero (stage 0), an unloading curve from the turning point `P` (stage 1), a reloading
//! curve from `Q` (stage 2). With `S` the force counted from the start of the present curve, `e = S / |S|`,
//! `c = 1` on stage 0 and 2 otherwise, the limit `L = mu F` (F the friction load of the normal law) and its step `dL`:
//!
//! `theta^3 = 1 - (|S| + c dL) / (c L)` in `[0, 1]`, and `theta = 1` where `dL > 0` and `8 G* a |ddelta| < dL`,
//!
//! `T += 8 G* a [theta (e.ddelta) e + (ddelta - (e.ddelta) e)] + (1 - theta) dL e`.
//!
//! A step against `S` is a turning point. A turning point moves out with the limit (`P -= dL e` on stage 1,
//! `Q -= dL e` and `P += dL P/|P|` on stage 2), and is forgotten when the force passes it: `|T - Q| >= |P - Q|`
//! on stage 2, `|T - P| >= 2 |P|` on stage 1. At the limit the force slides: `T *= L / |T|`, stage 0.

use granum_simd::{Real, cbrt};

use super::{LAW_CONSTANTS, MAX_HISTORY, Normal, PairProperties, Tangential, TangentialLaw};

/// Mindlin and Deresiewicz (1953), incremental, with two levels of turning points.
#[derive(Clone, Copy, Debug)]
pub struct MindlinDeresiewicz;

const EIGHT_MODULI: usize = 0;
const FRICTION: usize = 1;
const TURNING: usize = 3;
const RETURNING: usize = 6;
const STAGE: usize = 9;
const LOAD: usize = 10;

/// A force counted from the start of the present curve is nothing below this share of the limit.
const NOTHING: f64 = 1e-12;

/// What the law remembers, in a frame of `D` axes that turns with the contact plane.
struct State<R, const D: usize> {
    force: [R; D],
    turning: [R; D],
    returning: [R; D],
    stage: R,
}

#[inline(always)]
fn dot<R: Real, const D: usize>(a: [R; D], b: [R; D]) -> R {
    let mut sum = a[D - 1] * b[D - 1];
    for i in (0..D - 1).rev() {
        sum = a[i].mul_add(b[i], sum);
    }
    sum
}

#[inline(always)]
fn add_scaled<R: Real, const D: usize>(a: [R; D], s: R, b: [R; D]) -> [R; D] {
    std::array::from_fn(|i| s.mul_add(b[i], a[i]))
}

#[inline(always)]
fn select<R: Real, const D: usize>(mask: R::Mask, yes: [R; D], no: [R; D]) -> [R; D] {
    std::array::from_fn(|i| R::select(mask, yes[i], no[i]))
}

/// One step of the law; returns where it slides and by how much the force passed the limit.
#[inline(always)]
fn advance<R: Real, const D: usize>(
    state: &mut State<R, D>,
    step: [R; D],
    stiffness: R,
    limit: R,
    limit_before: R,
) -> (R::Mask, R) {
    let (zero, one, two) = (R::zero(), R::splat(1.0), R::splat(2.0));
    let tiny = R::splat(1e-300);
    let growth = limit - limit_before;
    let growth_square = growth * growth;

    // The force counted from the start of the present curve, and whether the step turns against it.
    let mut first = state.stage.lt(R::splat(0.5));
    let mut second = state.stage.eq(one);
    let origin: [R; D] =
        std::array::from_fn(|i| R::select(second, state.turning[i], state.returning[i]).keep(!first));
    let counted: [R; D] = std::array::from_fn(|i| state.force[i] - origin[i]);
    let counted_square = dot(counted, counted);
    let scale = R::splat(NOTHING) * limit;
    let directed = counted_square.gt(scale * scale);
    let turn = directed & dot(counted, step).lt(zero);
    let (returns, turns) = (turn & second, turn & !second);
    state.returning = select(returns, state.force, state.returning);
    state.turning = select(turns, state.force, state.turning);
    first = first & !turn;
    second = (second & !turn) | turns;
    let third = !(first | second);
    let curve = R::select(first, one, two);

    // Direction along which slip spreads.
    let along = directed & !turn;
    let vector = select(along, counted, step);
    let square = dot(vector, vector);
    let length = square.sqrt();
    let inverse = one / length.max(tiny);
    let direction: [R; D] = std::array::from_fn(|i| vector[i] * inverse);

    let cube = curve.mul_add(limit_before, -length.keep(along)) / (curve * limit).max(tiny);
    let stick = growth.gt(zero) & (stiffness * stiffness * dot(step, step)).lt(growth_square);
    let theta = R::select(stick, one, cbrt(cube.max(zero).min(one)));
    let elastic = add_scaled(state.force, stiffness, step);
    let slip = (one - theta) * stiffness.mul_add(-dot(direction, step), growth);
    let mut force = add_scaled(elastic, slip, direction);

    // Turning points move out with the limit and are forgotten when passed.
    state.turning = select(second, add_scaled(state.turning, -growth, direction), state.turning);
    let reach = dot(state.turning, state.turning);
    let outward = (growth / reach.max(tiny).sqrt()).keep(third);
    state.turning = add_scaled(state.turning, outward, state.turning);
    state.returning = add_scaled(state.returning, -growth.keep(third), direction);
    let gap = |a: [R; D], b: [R; D]| {
        let d: [R; D] = std::array::from_fn(|i| a[i] - b[i]);
        dot(d, d)
    };
    let passed_third = third & gap(force, state.returning).ge(gap(state.turning, state.returning));
    let passed_second = second & gap(force, state.turning).ge(R::splat(4.0) * reach);

    let trial_square = dot(force, force);
    let sliding = trial_square.ge(limit * limit);
    let trial = trial_square.max(tiny).sqrt();
    let factor = R::select(sliding, limit / trial, one);
    force = force.map(|f| f * factor);
    let home = first | passed_second | passed_third | sliding;
    state.stage = R::select(second, one, two).keep(!home);
    state.force = force;
    (sliding, (trial - limit).keep(sliding).max(zero))
}

impl TangentialLaw for MindlinDeresiewicz {
    const HISTORY: usize = 11;
    const VECTORS: usize = 3;

    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[EIGHT_MODULI] = 8.0 * pair.effective_shear_modulus;
        c[FRICTION] = pair.friction;
        c
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        _direction: [R; 3],
        increment: [R; 3],
        history: &mut [R; MAX_HISTORY],
    ) -> Tangential<R> {
        let stiffness = c[EIGHT_MODULI] * normal.radius;
        let limit = c[FRICTION] * normal.friction_load;
        let mut state: State<R, 3> = State {
            force: std::array::from_fn(|i| history[i]),
            turning: std::array::from_fn(|i| history[TURNING + i]),
            returning: std::array::from_fn(|i| history[RETURNING + i]),
            stage: history[STAGE],
        };
        let (sliding, excess) = advance(&mut state, increment, stiffness, limit, c[FRICTION] * history[LOAD]);
        history[..3].copy_from_slice(&state.force);
        history[TURNING..TURNING + 3].copy_from_slice(&state.turning);
        history[RETURNING..RETURNING + 3].copy_from_slice(&state.returning);
        history[STAGE] = state.stage;
        history[LOAD] = normal.friction_load;
        Tangential {
            force: state.force,
            stiffness,
            sliding,
            friction_loss: limit * excess / stiffness.max(R::splat(1e-300)),
        }
    }

    #[inline(always)]
    fn force<R: Real>(_direction: [R; 3], history: &[R; MAX_HISTORY]) -> [R; 3] {
        [history[0], history[1], history[2]]
    }
}
