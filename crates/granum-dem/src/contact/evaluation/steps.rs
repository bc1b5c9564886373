//! One step of a law of each kind: its history is rotated into the present contact plane, advanced, and discarded where the contact
//! ends.

use granum_simd::Real;

use crate::contact::evaluation::frame::Turn;
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::{
    MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::law::{
    AdhesionLaw, Attraction, Moment, MomentLaw, Normal, NormalLaw, RelativeSpin, Tangential, TangentialLaw,
};

/// A step of a normal law. The history is stored while the pair touches.
#[inline(always)]
pub(in crate::contact) fn normal_step<R: Real, N: NormalLaw>(
    constants: &N::Constants<R>,
    overlap: R,
    touched: R::Mask,
    history: &mut [R; MAX_NORMAL_HISTORY],
    energies: &mut LawEnergies<R>,
) -> Normal<R> {
    let contact = N::update(constants, overlap, touched, history, energies);
    for value in history.iter_mut().take(N::HISTORY) {
        *value = value.keep(contact.touching);
    }
    contact
}

/// A step of a tangential law: its result, its stiffness for the time step, and the force before the step.
#[inline(always)]
pub(in crate::contact) fn tangential_step<R: Real, T: TangentialLaw>(
    constants: &T::Constants<R>,
    normal: &Normal<R>,
    increment: [R; 2],
    turn: &Turn<R>,
    history: &mut [R; MAX_HISTORY],
    energies: &mut LawEnergies<R>,
) -> (Tangential<R>, R, [R; 2]) {
    for v in 0..T::PLANE_VECTORS {
        [history[2 * v], history[2 * v + 1]] = turn.apply([history[2 * v], history[2 * v + 1]]);
    }
    let before = [history[0], history[1]];
    let out = T::update(constants, normal, increment, history, energies);
    for value in history.iter_mut().take(T::HISTORY) {
        *value = value.keep(normal.touching);
    }
    (out, T::step_stiffness(constants, normal), before)
}

/// A step of a moment law.
#[inline(always)]
pub(in crate::contact) fn moment_step<R: Real, M: MomentLaw>(
    constants: &M::Constants<R>,
    normal: &Normal<R>,
    spin: RelativeSpin<R>,
    dt: R,
    turn: &Turn<R>,
    history: &mut [R; MAX_MOMENT_HISTORY],
    energies: &mut LawEnergies<R>,
) -> Moment<R> {
    for v in 0..M::PLANE_VECTORS {
        [history[2 * v], history[2 * v + 1]] = turn.apply([history[2 * v], history[2 * v + 1]]);
    }
    let out = M::update(constants, normal, spin, dt, history, energies);
    for value in history.iter_mut().take(M::HISTORY) {
        *value = value.keep(normal.touching);
    }
    out
}

/// A step of an adhesion law. The history is stored while the law acts; the volume of liquid of a bridge that has ruptured is kept
/// until it is returned to the films.
#[inline(always)]
pub(in crate::contact) fn adhesion_step<R: Real, A: AdhesionLaw>(
    constants: &A::Constants<R>,
    overlap: R,
    touching: R::Mask,
    history: &mut [R; MAX_ADHESION_HISTORY],
    energies: &mut LawEnergies<R>,
) -> Attraction<R> {
    let out = A::update(constants, overlap, touching, history, energies);
    for value in history.iter_mut().take(A::HISTORY).skip(usize::from(A::SHARES_LIQUID)) {
        *value = value.keep(out.acting);
    }
    out
}
