//! A law behind function pointers.
//!
//! A law is written over any lanes ([`NormalLaw`] and so on). A slot is such a law behind one function pointer that is
//! called once for two batches of eight contacts; the numbers are passed through memory as [`Column`]s. Each law is thus
//! compiled once for an instruction set, whatever laws it is combined with, and a program outside this workspace can add its
//! own.

use std::any::TypeId;

use granum_simd::{Isa, Kernel, Lanes, Real, dispatch};

use super::columns::{
    Batch, Column, Count, One, TwoBatches, Width, adhesion_call, moment_call, normal_call, read, read_normal,
    tangential_call, write, write_normal,
};
use super::law::{
    AdhesionLaw, AdhesionLosses, Description, MomentLaw, Normal, NormalLaw, NormalTraits, RelativeSpin,
    TangentialLaw,
};
use super::{LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, PairProperties};

/// A computation over columns, compiled for every width and instruction set.
trait Call {
    fn call<W: Width>(columns: &mut [Column]);
}

struct Run<'a, C>(Count, &'a mut [Column], std::marker::PhantomData<C>);

impl<C: Call> Kernel for Run<'_, C> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        match self.0 {
            Count::One => C::call::<One>(self.1),
            Count::Batch => C::call::<Batch<L>>(self.1),
            // The same bits without compiling a formula for which these lanes have too few registers.
            Count::TwoBatches if L::PAIRED => C::call::<TwoBatches<L>>(self.1),
            Count::TwoBatches => {
                C::call::<Batch<L>>(self.1);
                exchange(self.1);
                C::call::<Batch<L>>(self.1);
                exchange(self.1);
            }
        }
    }
}

fn exchange(columns: &mut [Column]) {
    for column in columns {
        column.swap(0, 1);
    }
}

fn run<C: Call>(isa: Isa, count: Count, columns: &mut [Column]) {
    dispatch(isa, Run::<C>(count, columns, std::marker::PhantomData));
}

struct NormalCall<N>(std::marker::PhantomData<N>);
impl<N: NormalLaw> Call for NormalCall<N> {
    #[inline(always)]
    fn call<W: Width>(columns: &mut [Column]) {
        use normal_call::*;
        let constants = read::<W, LAW_CONSTANTS>(columns, 0);
        let contact = N::evaluate(&constants, W::read(&columns[OVERLAP]), W::read_mask(&columns[TOUCHED]));
        write_normal::<W>(&contact, columns, CONTACT);
        let AdhesionLosses { made, broken } = N::losses(&constants);
        write::<W, 2>([made, broken], columns, LOSSES);
    }
}

struct TangentialCall<T>(std::marker::PhantomData<T>);
impl<T: TangentialLaw> Call for TangentialCall<T> {
    #[inline(always)]
    fn call<W: Width>(columns: &mut [Column]) {
        use tangential_call::*;
        let constants = read::<W, LAW_CONSTANTS>(columns, 0);
        let contact = read_normal::<W>(columns, CONTACT);
        let increment = read::<W, 2>(columns, INCREMENT);
        let mut history = [W::Value::zero(); MAX_HISTORY];
        for (c, value) in history.iter_mut().enumerate().take(T::HISTORY) {
            *value = W::read(&columns[HISTORY + c]);
        }
        let out = T::update(&constants, &contact, increment, &mut history);
        for (c, value) in history.iter().enumerate().take(T::HISTORY) {
            W::write(*value, &mut columns[HISTORY + c]);
        }
        let [x, y] = out.force;
        let step = T::step_stiffness(&constants, &contact);
        let numbers = [x, y, out.stiffness, out.root_stiffness, out.friction_loss, out.micro_slip_loss, step];
        write::<W, 7>(numbers, columns, RESULT);
        W::write_mask(out.sliding, &mut columns[SLIDING]);
        W::write_mask(out.discards, &mut columns[DISCARDS]);
    }
}

/// Columns: constants, stiffness, history; the loss is returned in the first.
struct DiscardedCall<T>(std::marker::PhantomData<T>);
impl<T: TangentialLaw> Call for DiscardedCall<T> {
    #[inline(always)]
    fn call<W: Width>(columns: &mut [Column]) {
        let constants = read::<W, LAW_CONSTANTS>(columns, 0);
        let stiffness = W::read(&columns[LAW_CONSTANTS]);
        let history = read::<W, MAX_HISTORY>(columns, LAW_CONSTANTS + 1);
        W::write(T::discarded(&constants, stiffness, &history), &mut columns[0]);
    }
}

struct MomentCall<M>(std::marker::PhantomData<M>);
impl<M: MomentLaw> Call for MomentCall<M> {
    #[inline(always)]
    fn call<W: Width>(columns: &mut [Column]) {
        use moment_call::*;
        let constants = read::<W, LAW_CONSTANTS>(columns, 0);
        let contact = read_normal::<W>(columns, CONTACT);
        let [x, y, twisting] = read::<W, 3>(columns, SPIN);
        let dt = W::read(&columns[TIME_STEP]);
        let mut history = read::<W, MAX_MOMENT_HISTORY>(columns, HISTORY);
        let spin = RelativeSpin { rolling: [x, y], twisting };
        let out = M::update(&constants, &contact, spin, dt, &mut history);
        write::<W, MAX_MOMENT_HISTORY>(history, columns, HISTORY);
        let [a, b, c] = out.couple;
        let numbers = [a, b, c, out.dashpot, out.twisting_dashpot, out.work, out.loss, out.step_stiffness];
        write::<W, 8>(numbers, columns, RESULT);
        W::write_mask(out.at_limit, &mut columns[AT_LIMIT]);
    }
}

struct AdhesionCall<A>(std::marker::PhantomData<A>);
impl<A: AdhesionLaw> Call for AdhesionCall<A> {
    #[inline(always)]
    fn call<W: Width>(columns: &mut [Column]) {
        use adhesion_call::*;
        let constants = read::<W, LAW_CONSTANTS>(columns, 0);
        let mut history = read::<W, MAX_ADHESION_HISTORY>(columns, HISTORY);
        let touching = W::read_mask(&columns[TOUCHING]);
        let out = A::update(&constants, W::read(&columns[OVERLAP]), touching, &mut history);
        write::<W, MAX_ADHESION_HISTORY>(history, columns, HISTORY);
        write::<W, 3>([out.force, out.stiffness, out.loss], columns, RESULT);
        W::write_mask(out.acting, &mut columns[ACTING]);
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
    /// [`NormalLaw::evaluate`] and [`NormalLaw::losses`] over columns.
    fn evaluate(&self, isa: Isa, count: Count, columns: &mut [Column]);
    /// [`NormalLaw::loaded`].
    fn loaded(&self, pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64>;
    /// [`NormalLaw::energy`].
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], overlap: f64) -> f64;
    /// [`NormalLaw::breaking_overlap`].
    fn breaking_overlap(&self, constants: &[f64; LAW_CONSTANTS]) -> f64;
    /// [`NormalLaw::evaluate`] for one contact that touched.
    fn of_touching(&self, constants: &[f64; LAW_CONSTANTS], overlap: f64) -> Normal<f64>;
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
    fn evaluate(&self, isa: Isa, count: Count, columns: &mut [Column]) {
        run::<NormalCall<N>>(isa, count, columns);
    }
    fn loaded(&self, pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        N::loaded(pair, parameters, load)
    }
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], overlap: f64) -> f64 {
        N::energy(constants, overlap)
    }
    fn breaking_overlap(&self, constants: &[f64; LAW_CONSTANTS]) -> f64 {
        N::breaking_overlap(constants)
    }
    fn of_touching(&self, constants: &[f64; LAW_CONSTANTS], overlap: f64) -> Normal<f64> {
        N::evaluate(constants, overlap, true)
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
    fn update(&self, isa: Isa, count: Count, columns: &mut [Column]);
    /// [`TangentialLaw::discarded`] over columns.
    fn discarded(&self, isa: Isa, count: Count, columns: &mut [Column]);
    /// [`TangentialLaw::stiffness`] and [`TangentialLaw::step_stiffness`] for one contact.
    fn stiffness(&self, constants: &[f64; LAW_CONSTANTS], normal: &Normal<f64>) -> [f64; 2];
    /// [`TangentialLaw::energy`].
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], stiffness: f64, history: &[f64; MAX_HISTORY]) -> f64;
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
    fn update(&self, isa: Isa, count: Count, columns: &mut [Column]) {
        run::<TangentialCall<T>>(isa, count, columns);
    }
    fn discarded(&self, isa: Isa, count: Count, columns: &mut [Column]) {
        if T::DISCARDS {
            run::<DiscardedCall<T>>(isa, count, columns);
        }
    }
    fn stiffness(&self, constants: &[f64; LAW_CONSTANTS], normal: &Normal<f64>) -> [f64; 2] {
        [T::stiffness(constants, normal), T::step_stiffness(constants, normal)]
    }
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], stiffness: f64, history: &[f64; MAX_HISTORY]) -> f64 {
        T::energy(constants, stiffness, history)
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
    fn update(&self, isa: Isa, count: Count, columns: &mut [Column]);
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
    fn update(&self, isa: Isa, count: Count, columns: &mut [Column]) {
        if M::ACTS {
            run::<MomentCall<M>>(isa, count, columns);
        }
    }
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        M::energy(constants, history)
    }
}

/// A law of adhesion behind function pointers. Every [`AdhesionLaw`] is one.
pub trait AdhesionSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`AdhesionLaw::ACTS`].
    fn acts(&self) -> bool;
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
    fn update(&self, isa: Isa, count: Count, columns: &mut [Column]);
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
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str> {
        A::goes_with(normal)
    }
    fn history(&self) -> usize {
        A::HISTORY
    }
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        A::prepare(pair, parameters)
    }
    fn update(&self, isa: Isa, count: Count, columns: &mut [Column]) {
        if A::ACTS {
            run::<AdhesionCall<A>>(isa, count, columns);
        }
    }
    fn at_touch(&self, constants: &[f64; LAW_CONSTANTS]) -> [f64; 2] {
        let out = A::update(constants, 0.0, true, &mut [0.0; MAX_ADHESION_HISTORY]);
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
