//! One step of a law of each kind: its history is rotated into the present contact plane, advanced, and discarded where the contact
//! ends.

use granum_simd::Real;

use super::frame::Turn;
use super::law::{
    AdhesionLaw, Attraction, Moment, MomentLaw, Normal, NormalLaw, RelativeSpin, Tangential, TangentialLaw,
};
use super::limits::{
    LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};

/// A step of a normal law. The history is stored while the pair touches.
#[inline(always)]
pub(super) fn normal_step<R: Real, N: NormalLaw>(
    constants: &[R; LAW_CONSTANTS],
    overlap: R,
    touched: R::Mask,
    history: &mut [R; MAX_NORMAL_HISTORY],
) -> (Normal<R>, R) {
    let (contact, loss) = N::update(constants, overlap, touched, history);
    for value in history.iter_mut().take(N::HISTORY) {
        *value = value.keep(contact.touching);
    }
    (contact, loss)
}

/// A step of a tangential law: its result, its stiffness for the time step, and the force before the step.
#[inline(always)]
pub(super) fn tangential_step<R: Real, T: TangentialLaw>(
    constants: &[R; LAW_CONSTANTS],
    normal: &Normal<R>,
    increment: [R; 2],
    turn: &Turn<R>,
    history: &mut [R; MAX_HISTORY],
) -> (Tangential<R>, R, [R; 2]) {
    for v in 0..T::PLANE_VECTORS {
        [history[2 * v], history[2 * v + 1]] = turn.apply([history[2 * v], history[2 * v + 1]]);
    }
    let before = [history[0], history[1]];
    let out = T::update(constants, normal, increment, history);
    for value in history.iter_mut().take(T::HISTORY) {
        *value = value.keep(normal.touching);
    }
    (out, T::step_stiffness(constants, normal), before)
}

/// A step of a moment law.
#[inline(always)]
pub(super) fn moment_step<R: Real, M: MomentLaw>(
    constants: &[R; LAW_CONSTANTS],
    normal: &Normal<R>,
    spin: RelativeSpin<R>,
    dt: R,
    turn: &Turn<R>,
    history: &mut [R; MAX_MOMENT_HISTORY],
) -> Moment<R> {
    for v in 0..M::PLANE_VECTORS {
        [history[2 * v], history[2 * v + 1]] = turn.apply([history[2 * v], history[2 * v + 1]]);
    }
    let out = M::update(constants, normal, spin, dt, history);
    for value in history.iter_mut().take(M::HISTORY) {
        *value = value.keep(normal.touching);
    }
    out
}

/// A step of an adhesion law. The history is stored while the law acts; the volume of liquid of a bridge that has ruptured is kept
/// until it is returned to the films.
#[inline(always)]
pub(super) fn adhesion_step<R: Real, A: AdhesionLaw>(
    constants: &[R; LAW_CONSTANTS],
    overlap: R,
    touching: R::Mask,
    history: &mut [R; MAX_ADHESION_HISTORY],
) -> Attraction<R> {
    let out = A::update(constants, overlap, touching, history);
    for value in history.iter_mut().take(A::HISTORY).skip(usize::from(A::SHARES_LIQUID)) {
        *value = value.keep(out.acting);
    }
    out
}
