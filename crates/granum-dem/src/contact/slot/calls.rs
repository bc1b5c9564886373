//! The computations of laws over the columns of a [`Sheet`], which are called through function pointers.

use granum_simd::{Mask, Real};

use super::columns::{Sheet, Width, at, read, read_normal, write, write_normal};
use super::entry::Call;
use crate::contact::evaluation::frame::Turn;
use crate::contact::evaluation::steps::{adhesion_step, moment_step, normal_step, tangential_step};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::{
    LAW_CHANNELS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::law::{AdhesionLaw, AdhesionLosses, MomentLaw, NormalLaw, RelativeSpin, TangentialLaw};

/// Channels into which nothing has been put.
#[inline(always)]
pub(super) fn no_energies<R: Real>() -> LawEnergies<R> {
    [R::zero(); LAW_CHANNELS]
}

pub(super) struct NormalCall<N>(std::marker::PhantomData<N>);
impl<N: NormalLaw> Call for NormalCall<N> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W, N::Constants<W::Value>>();
        let mut history = sheet.history::<W, MAX_NORMAL_HISTORY>(N::HISTORY);
        let overlap = W::read(&sheet.columns[at::OVERLAP]);
        let touched = W::read_mask(&sheet.columns[at::TOUCHED]);
        let mut energies = no_energies();
        let contact = normal_step::<_, N>(&constants, overlap, touched, &mut history, &mut energies);
        sheet.keep::<W, MAX_NORMAL_HISTORY>(&history, N::HISTORY);
        sheet.account::<W>(&energies, N::CHANNELS);
        write_normal::<W>(&contact, sheet.columns);
        let AdhesionLosses { made, broken } = N::losses(&constants);
        write::<W, 2>([made, broken], sheet.columns, at::LOSSES);
    }
}

pub(super) struct TangentialCall<T>(std::marker::PhantomData<T>);
impl<T: TangentialLaw> Call for TangentialCall<T> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W, T::Constants<W::Value>>();
        let contact = read_normal::<W>(sheet.columns);
        let [x, y, cosine, sine] = read::<W, 4>(sheet.columns, at::INCREMENT);
        let mut history = sheet.history::<W, MAX_HISTORY>(T::HISTORY);
        let (turn, mut energies) = (Turn { cosine, sine }, no_energies());
        let (out, step, before) =
            tangential_step::<_, T>(&constants, &contact, [x, y], &turn, &mut history, &mut energies);
        sheet.keep::<W, MAX_HISTORY>(&history, T::HISTORY);
        sheet.account::<W>(&energies, T::CHANNELS);
        let [x, y] = out.force;
        let numbers = [
            before[0],
            before[1],
            x,
            y,
            out.stiffness,
            out.root_stiffness,
            out.friction_loss,
            out.micro_slip_loss,
            step,
        ];
        write::<W, 9>(numbers, sheet.columns, at::TANGENTIAL);
        W::write_mask(out.sliding, &mut sheet.columns[at::SLIDING]);
        W::write_mask(out.discards, &mut sheet.columns[at::DISCARDS]);
    }
}

/// The first column contains the stiffness at the call and the loss at the return.
pub(super) struct DiscardedCall<T>(std::marker::PhantomData<T>);
impl<T: TangentialLaw> Call for DiscardedCall<T> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W, T::Constants<W::Value>>();
        let history = sheet.history::<W, MAX_HISTORY>(T::HISTORY);
        let lost = T::discarded(&constants, W::read(&sheet.columns[0]), &history);
        W::write(lost, &mut sheet.columns[0]);
    }
}

pub(super) struct MomentCall<M>(std::marker::PhantomData<M>);
impl<M: MomentLaw> Call for MomentCall<M> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W, M::Constants<W::Value>>();
        let contact = read_normal::<W>(sheet.columns);
        let [cosine, sine, x, y, twisting, dt] = read::<W, 6>(sheet.columns, at::TURN);
        let mut history = sheet.history::<W, MAX_MOMENT_HISTORY>(M::HISTORY);
        let (spin, turn) = (RelativeSpin { rolling: [x, y], twisting }, Turn { cosine, sine });
        let mut energies = no_energies();
        let out = moment_step::<_, M>(&constants, &contact, spin, dt, &turn, &mut history, &mut energies);
        sheet.keep::<W, MAX_MOMENT_HISTORY>(&history, M::HISTORY);
        sheet.account::<W>(&energies, M::CHANNELS);
        let [a, b, c] = out.couple;
        let numbers = [a, b, c, out.dashpot, out.twisting_dashpot, out.work, out.loss, out.step_stiffness];
        write::<W, 8>(numbers, sheet.columns, at::MOMENT);
        W::write_mask(out.at_limit, &mut sheet.columns[at::AT_LIMIT]);
    }
}

pub(super) struct AdhesionCall<A>(std::marker::PhantomData<A>);
impl<A: AdhesionLaw> Call for AdhesionCall<A> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W, A::Constants<W::Value>>();
        let mut history = sheet.history::<W, MAX_ADHESION_HISTORY>(A::HISTORY);
        let touching = W::read_mask(&sheet.columns[at::TOUCHING]);
        let overlap = W::read(&sheet.columns[at::OVERLAP]);
        let mut energies = no_energies();
        let out = adhesion_step::<_, A>(&constants, overlap, touching, &mut history, &mut energies);
        sheet.account::<W>(&energies, A::CHANNELS);
        // The history of a bridge that holds liquid changes only where it ruptures.
        if !A::SHARES_LIQUID || (history[0].gt(W::Value::zero()) & !out.acting).any() {
            sheet.keep::<W, MAX_ADHESION_HISTORY>(&history, A::HISTORY);
        }
        write::<W, 3>([out.force, out.stiffness, out.loss], sheet.columns, at::ADHESION);
        W::write_mask(out.acting, &mut sheet.columns[at::ACTING]);
    }
}
