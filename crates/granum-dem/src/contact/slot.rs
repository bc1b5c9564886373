//! A law behind function pointers.
//!
//! A law is written over any lanes ([`NormalLaw`] and so on). A slot is such a law behind one function pointer that is
//! called once for a batch of eight contacts; the numbers are passed through memory ([`Sheet`]). Each law is thus
//! compiled once for an instruction set, whatever laws it is combined with, and a program outside this workspace can add its
//! own.

use std::any::TypeId;

use granum_simd::{Isa, Mask, Real, fused};

use super::columns::{Count, Sheet, Width, at, read, read_normal, write, write_normal};
use super::description::Description;
use super::entry::{Call, Entry};
use super::frame::Turn;
use super::law::{
    AdhesionLaw, AdhesionLosses, MomentLaw, Normal, NormalLaw, NormalTraits, RelativeSpin, TangentialLaw,
};
use super::observed::{self, ObservedBatch};
use super::steps::{adhesion_step, moment_step, normal_step, tangential_step};
use crate::contact::limits::{
    LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::pair_properties::PairProperties;

struct NormalCall<N>(std::marker::PhantomData<N>);
impl<N: NormalLaw> Call for NormalCall<N> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W>();
        let mut history = sheet.history::<W, MAX_NORMAL_HISTORY>(N::HISTORY);
        let overlap = W::read(&sheet.columns[at::OVERLAP]);
        let touched = W::read_mask(&sheet.columns[at::TOUCHED]);
        let (contact, plastic) = normal_step::<_, N>(&constants, overlap, touched, &mut history);
        sheet.keep::<W, MAX_NORMAL_HISTORY>(&history, N::HISTORY);
        write_normal::<W>(&contact, sheet.columns);
        let AdhesionLosses { made, broken } = N::losses(&constants);
        write::<W, 3>([made, broken, plastic], sheet.columns, at::LOSSES);
    }
}

struct TangentialCall<T>(std::marker::PhantomData<T>);
impl<T: TangentialLaw> Call for TangentialCall<T> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W>();
        let contact = read_normal::<W>(sheet.columns);
        let [x, y, cosine, sine] = read::<W, 4>(sheet.columns, at::INCREMENT);
        let mut history = sheet.history::<W, MAX_HISTORY>(T::HISTORY);
        let turn = Turn { cosine, sine };
        let (out, step, before) = tangential_step::<_, T>(&constants, &contact, [x, y], &turn, &mut history);
        sheet.keep::<W, MAX_HISTORY>(&history, T::HISTORY);
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
struct DiscardedCall<T>(std::marker::PhantomData<T>);
impl<T: TangentialLaw> Call for DiscardedCall<T> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W>();
        let history = sheet.history::<W, MAX_HISTORY>(T::HISTORY);
        let lost = T::discarded(&constants, W::read(&sheet.columns[0]), &history);
        W::write(lost, &mut sheet.columns[0]);
    }
}

struct MomentCall<M>(std::marker::PhantomData<M>);
impl<M: MomentLaw> Call for MomentCall<M> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W>();
        let contact = read_normal::<W>(sheet.columns);
        let [cosine, sine, x, y, twisting, dt] = read::<W, 6>(sheet.columns, at::TURN);
        let mut history = sheet.history::<W, MAX_MOMENT_HISTORY>(M::HISTORY);
        let (spin, turn) = (RelativeSpin { rolling: [x, y], twisting }, Turn { cosine, sine });
        let out = moment_step::<_, M>(&constants, &contact, spin, dt, &turn, &mut history);
        sheet.keep::<W, MAX_MOMENT_HISTORY>(&history, M::HISTORY);
        let [a, b, c] = out.couple;
        let numbers = [a, b, c, out.dashpot, out.twisting_dashpot, out.work, out.loss, out.step_stiffness];
        write::<W, 8>(numbers, sheet.columns, at::MOMENT);
        W::write_mask(out.at_limit, &mut sheet.columns[at::AT_LIMIT]);
    }
}

struct AdhesionCall<A>(std::marker::PhantomData<A>);
impl<A: AdhesionLaw> Call for AdhesionCall<A> {
    #[inline(always)]
    fn call<W: Width>(sheet: &mut Sheet<'_>) {
        let constants = sheet.constants::<W>();
        let mut history = sheet.history::<W, MAX_ADHESION_HISTORY>(A::HISTORY);
        let touching = W::read_mask(&sheet.columns[at::TOUCHING]);
        let overlap = W::read(&sheet.columns[at::OVERLAP]);
        let out = adhesion_step::<_, A>(&constants, overlap, touching, &mut history);
        // The history of a bridge that holds liquid changes only where it ruptures.
        if !A::SHARES_LIQUID || (history[0].gt(W::Value::zero()) & !out.acting).any() {
            sheet.keep::<W, MAX_ADHESION_HISTORY>(&history, A::HISTORY);
        }
        write::<W, 3>([out.force, out.stiffness, out.loss], sheet.columns, at::ADHESION);
        W::write_mask(out.acting, &mut sheet.columns[at::ACTING]);
    }
}

/// A normal law behind function pointers. Every [`NormalLaw`] implements it.
pub trait NormalSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// Properties that other laws depend on.
    fn traits(&self) -> NormalTraits;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`NormalLaw::prepare`].
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// [`NormalLaw::HISTORY`].
    fn history(&self) -> usize;
    /// [`NormalLaw::update`] and [`NormalLaw::losses`] over columns.
    fn evaluate(&self, isa: Isa, count: Count) -> Entry;
    /// [`NormalLaw::loaded`].
    fn loaded(&self, pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64>;
    /// [`NormalLaw::update`] and [`NormalLaw::stored`] for pairs with their histories.
    fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]);
    /// [`NormalLaw::breaking_overlap`].
    fn breaking_overlap(&self, constants: &[f64; LAW_CONSTANTS]) -> f64;
    /// [`NormalLaw::update`] for one contact that touched with this history.
    fn of_touching(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        history: &[f64; MAX_NORMAL_HISTORY],
    ) -> Normal<f64>;
}

impl<N: NormalLaw> NormalSlot for N {
    fn description(&self) -> &'static Description {
        &N::DESCRIPTION
    }
    fn traits(&self) -> NormalTraits {
        let name = N::DESCRIPTION.name;
        NormalTraits { name, contact_area: N::CONTACT_AREA, adhesive: N::ADHESIVE }
    }
    fn id(&self) -> TypeId {
        TypeId::of::<N>()
    }
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        N::prepare(pair, parameters)
    }
    fn history(&self) -> usize {
        N::HISTORY
    }
    fn evaluate(&self, isa: Isa, count: Count) -> Entry {
        Entry::of::<NormalCall<N>>(isa, count)
    }
    fn loaded(&self, pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        N::loaded(pair, parameters, load)
    }
    fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]) {
        observed::normal::<N>(isa, contacts);
    }
    fn breaking_overlap(&self, constants: &[f64; LAW_CONSTANTS]) -> f64 {
        N::breaking_overlap(constants)
    }
    fn of_touching(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        history: &[f64; MAX_NORMAL_HISTORY],
    ) -> Normal<f64> {
        fused(
            #[inline(always)]
            || N::update(constants, overlap, true, &mut { *history }).0,
        )
    }
}

/// A tangential law behind function pointers. Every [`TangentialLaw`] implements it.
pub trait TangentialSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`TangentialLaw::goes_with`].
    ///
    /// # Errors
    /// The reason why they cannot be combined.
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str>;
    /// Number of history columns, and of plane vectors at their beginning.
    fn history(&self) -> [usize; 2];
    /// [`TangentialLaw::DISCARDS`].
    fn discards(&self) -> bool;
    /// [`TangentialLaw::prepare`].
    fn prepare(
        &self,
        pair: &PairProperties,
        normal: &NormalTraits,
        parameters: &[f64],
    ) -> [f64; LAW_CONSTANTS];
    /// [`TangentialLaw::update`] over columns.
    fn update(&self, isa: Isa, count: Count) -> Entry;
    /// [`TangentialLaw::discarded`] over columns.
    fn discarded(&self, isa: Isa, count: Count) -> Entry;
    /// [`TangentialLaw::stiffness`] and [`TangentialLaw::step_stiffness`] for one contact.
    fn stiffness(&self, constants: &[f64; LAW_CONSTANTS], normal: &Normal<f64>) -> [f64; 2];
    /// [`TangentialLaw::energy`] for pairs whose normal part is known.
    fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]);
}

impl<T: TangentialLaw> TangentialSlot for T {
    fn description(&self) -> &'static Description {
        &T::DESCRIPTION
    }
    fn id(&self) -> TypeId {
        TypeId::of::<T>()
    }
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str> {
        T::goes_with(normal)
    }
    fn history(&self) -> [usize; 2] {
        [T::HISTORY, T::PLANE_VECTORS]
    }
    fn discards(&self) -> bool {
        T::DISCARDS
    }
    fn prepare(
        &self,
        pair: &PairProperties,
        normal: &NormalTraits,
        parameters: &[f64],
    ) -> [f64; LAW_CONSTANTS] {
        T::prepare(pair, normal, parameters)
    }
    fn update(&self, isa: Isa, count: Count) -> Entry {
        Entry::of::<TangentialCall<T>>(isa, count)
    }
    fn discarded(&self, isa: Isa, count: Count) -> Entry {
        if T::DISCARDS { Entry::of::<DiscardedCall<T>>(isa, count) } else { Entry::none() }
    }
    fn stiffness(&self, constants: &[f64; LAW_CONSTANTS], normal: &Normal<f64>) -> [f64; 2] {
        [T::stiffness(constants, normal), T::step_stiffness(constants, normal)]
    }
    fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]) {
        observed::tangential::<T>(isa, contacts);
    }
}

/// A moment law behind function pointers. Every [`MomentLaw`] implements it.
pub trait MomentSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`MomentLaw::ACTS`].
    fn acts(&self) -> bool;
    /// Number of history columns, and of plane vectors at their beginning.
    fn history(&self) -> [usize; 2];
    /// [`MomentLaw::prepare`].
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// [`MomentLaw::update`] over columns.
    fn update(&self, isa: Isa, count: Count) -> Entry;
    /// [`MomentLaw::energy`].
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64;
}

impl<M: MomentLaw> MomentSlot for M {
    fn description(&self) -> &'static Description {
        &M::DESCRIPTION
    }
    fn id(&self) -> TypeId {
        TypeId::of::<M>()
    }
    fn acts(&self) -> bool {
        M::ACTS
    }
    fn history(&self) -> [usize; 2] {
        [M::HISTORY, M::PLANE_VECTORS]
    }
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        M::prepare(pair, parameters)
    }
    fn update(&self, isa: Isa, count: Count) -> Entry {
        if M::ACTS { Entry::of::<MomentCall<M>>(isa, count) } else { Entry::none() }
    }
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        M::energy(constants, history)
    }
}

/// An adhesion law behind function pointers. Every [`AdhesionLaw`] implements it.
pub trait AdhesionSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`AdhesionLaw::ACTS`].
    fn acts(&self) -> bool;
    /// [`AdhesionLaw::BEGINS_AT_TOUCH`].
    fn begins_at_touch(&self) -> bool;
    /// [`AdhesionLaw::SHARES_LIQUID`].
    fn shares_liquid(&self) -> bool;
    /// [`AdhesionLaw::film`].
    fn film(&self, radius: f64, parameters: &[f64]) -> f64;
    /// [`AdhesionLaw::largest_bridge`].
    fn largest_bridge(&self, constants: &[f64; LAW_CONSTANTS]) -> f64;
    /// [`AdhesionLaw::bridge`].
    fn bridge(&self, constants: &[f64; LAW_CONSTANTS], volume: f64) -> [f64; MAX_ADHESION_HISTORY];
    /// [`AdhesionLaw::goes_with`].
    ///
    /// # Errors
    /// The reason why they cannot be combined.
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str>;
    /// Columns of history.
    fn history(&self) -> usize;
    /// [`AdhesionLaw::prepare`].
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// [`AdhesionLaw::update`] over columns.
    fn update(&self, isa: Isa, count: Count) -> Entry;
    /// Force and stiffness of a pair that just touches, N and N/m.
    fn at_touch(&self, constants: &[f64; LAW_CONSTANTS]) -> [f64; 2];
    /// Force of a pair with this history, N.
    fn force(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        touching: bool,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64;
    /// [`AdhesionLaw::energy`].
    fn energy(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64;
    /// [`AdhesionLaw::range`].
    fn range(&self, constants: &[f64; LAW_CONSTANTS]) -> f64;
}

impl<A: AdhesionLaw> AdhesionSlot for A {
    fn description(&self) -> &'static Description {
        &A::DESCRIPTION
    }
    fn id(&self) -> TypeId {
        TypeId::of::<A>()
    }
    fn acts(&self) -> bool {
        A::ACTS
    }
    fn begins_at_touch(&self) -> bool {
        A::BEGINS_AT_TOUCH
    }
    fn shares_liquid(&self) -> bool {
        A::SHARES_LIQUID
    }
    fn film(&self, radius: f64, parameters: &[f64]) -> f64 {
        A::film(radius, parameters)
    }
    fn largest_bridge(&self, constants: &[f64; LAW_CONSTANTS]) -> f64 {
        A::largest_bridge(constants)
    }
    fn bridge(&self, constants: &[f64; LAW_CONSTANTS], volume: f64) -> [f64; MAX_ADHESION_HISTORY] {
        A::bridge(constants, volume)
    }
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str> {
        A::goes_with(normal)
    }
    fn history(&self) -> usize {
        A::HISTORY
    }
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        A::prepare(pair, parameters)
    }
    fn update(&self, isa: Isa, count: Count) -> Entry {
        if A::ACTS { Entry::of::<AdhesionCall<A>>(isa, count) } else { Entry::none() }
    }
    fn at_touch(&self, constants: &[f64; LAW_CONSTANTS]) -> [f64; 2] {
        let mut history = match A::SHARES_LIQUID {
            true => A::bridge(constants, A::largest_bridge(constants)),
            false => [0.0; MAX_ADHESION_HISTORY],
        };
        let out = A::update(constants, 0.0, true, &mut history);
        [out.force, out.stiffness]
    }
    fn force(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        touching: bool,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        A::update(constants, overlap, touching, &mut { *history }).force
    }
    fn energy(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        A::energy(constants, overlap, history)
    }
    fn range(&self, constants: &[f64; LAW_CONSTANTS]) -> f64 {
        A::range(constants)
    }
}
