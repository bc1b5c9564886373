//! A law as a value that is chosen at run time.
//!
//! A law is written over any lanes ([`NormalLaw`] and so on). A slot is that law behind one function pointer that is called once
//! for two batches of eight contacts; the numbers go through memory as [`Column`]s. So each law is compiled once for an
//! instruction set, whatever laws it is used with, and a program outside this workspace can bring its own.

use std::any::TypeId;
use std::fmt;
use std::hash::{Hash, Hasher};

use granum_simd::{Isa, Kernel, Lanes, Real, Row8, Twice, dispatch};

use super::law::{
    AdhesionLosses, Description, MomentLaw, Normal, NormalLaw, NormalTraits, RelativeSpin, TangentialLaw,
};
use super::normal::{Hertz, Hooke, Jkr};
use super::rolling::{ElasticPlasticRolling, NoMoments};
use super::tangential::{MindlinDeresiewicz, NoSlip, Peeling};
use super::{LAW_CONSTANTS, MAX_HISTORY, MAX_MOMENT_HISTORY, PairProperties};

/// One number of a contact, for up to two batches of eight contacts.
pub type Column = [Row8; 2];

/// How many contacts a call computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// One contact, in the first place of every column.
    One,
    /// One batch of eight.
    Batch,
    /// Two batches.
    TwoBatches,
}

/// Numbers that a call computes at once, and where they stand in a column.
pub trait Width {
    /// The numbers.
    type Value: Real;
    /// How many.
    const COUNT: Count;
    /// Reads them.
    fn read(column: &Column) -> Self::Value;
    /// Writes them.
    fn write(value: Self::Value, column: &mut Column);
    /// Writes a mask as ones and zeros.
    #[inline(always)]
    fn write_mask(mask: <Self::Value as Real>::Mask, column: &mut Column) {
        Self::write(Self::Value::splat(1.0).keep(mask), column);
    }
    /// Reads a mask written as ones and zeros.
    #[inline(always)]
    fn read_mask(column: &Column) -> <Self::Value as Real>::Mask {
        Self::read(column).gt(Self::Value::zero())
    }
}

/// One contact.
#[derive(Clone, Copy)]
pub struct One;
/// A batch.
#[derive(Clone, Copy)]
pub struct Batch<L>(std::marker::PhantomData<L>);
/// Two batches.
#[derive(Clone, Copy)]
pub struct TwoBatches<L>(std::marker::PhantomData<L>);

impl Width for One {
    type Value = f64;
    const COUNT: Count = Count::One;
    #[inline(always)]
    fn read(column: &Column) -> f64 {
        column[0].0[0]
    }
    #[inline(always)]
    fn write(value: f64, column: &mut Column) {
        column[0].0[0] = value;
    }
}
impl<L: Lanes> Width for Batch<L> {
    type Value = L;
    const COUNT: Count = Count::Batch;
    #[inline(always)]
    fn read(column: &Column) -> L {
        L::load(&column[0].0)
    }
    #[inline(always)]
    fn write(value: L, column: &mut Column) {
        value.store(&mut column[0].0);
    }
}
impl<L: Lanes> Width for TwoBatches<L> {
    type Value = Twice<L>;
    const COUNT: Count = Count::TwoBatches;
    #[inline(always)]
    fn read(column: &Column) -> Twice<L> {
        Twice(L::load(&column[0].0), L::load(&column[1].0))
    }
    #[inline(always)]
    fn write(value: Twice<L>, column: &mut Column) {
        value.0.store(&mut column[0].0);
        value.1.store(&mut column[1].0);
    }
}

/// Reads consecutive columns.
#[inline(always)]
pub(super) fn read<W: Width, const N: usize>(columns: &[Column], from: usize) -> [W::Value; N] {
    std::array::from_fn(
        #[inline(always)]
        |c| W::read(&columns[from + c]),
    )
}

/// Writes consecutive columns.
#[inline(always)]
pub(super) fn write<W: Width, const N: usize>(values: [W::Value; N], columns: &mut [Column], from: usize) {
    for (c, value) in values.into_iter().enumerate() {
        W::write(value, &mut columns[from + c]);
    }
}

/// Columns of a contact's normal part, as it goes from slot to slot: the numbers of [`Normal`] and where it touches.
pub(super) const NORMAL_COLUMNS: usize = 8;

#[inline(always)]
pub(super) fn write_normal<W: Width>(normal: &Normal<W::Value>, columns: &mut [Column], from: usize) {
    let numbers = [
        normal.force,
        normal.radius,
        normal.stiffness,
        normal.root_stiffness,
        normal.tangential_measure,
        normal.root_tangential_measure,
        normal.friction_load,
    ];
    write::<W, 7>(numbers, columns, from);
    W::write_mask(normal.touching, &mut columns[from + 7]);
}

#[inline(always)]
pub(super) fn read_normal<W: Width>(columns: &[Column], from: usize) -> Normal<W::Value> {
    let [
        force,
        radius,
        stiffness,
        root_stiffness,
        tangential_measure,
        root_tangential_measure,
        friction_load,
    ] = read::<W, 7>(columns, from);
    Normal {
        force,
        radius,
        stiffness,
        root_stiffness,
        tangential_measure,
        root_tangential_measure,
        friction_load,
        touching: W::read_mask(&columns[from + 7]),
    }
}

/// Columns of a call to a normal law: constants, overlap, whether it touched; then the contact and the losses.
pub(super) mod normal_call {
    use super::{LAW_CONSTANTS, NORMAL_COLUMNS};
    pub const OVERLAP: usize = LAW_CONSTANTS;
    pub const TOUCHED: usize = OVERLAP + 1;
    pub const CONTACT: usize = TOUCHED + 1;
    pub const LOSSES: usize = CONTACT + NORMAL_COLUMNS;
    pub const ALL: usize = LOSSES + 2;
}

/// Columns of a call to a tangential law: constants, contact, increment, history; then force, stiffnesses, masks, losses.
pub(super) mod tangential_call {
    use super::{LAW_CONSTANTS, MAX_HISTORY, NORMAL_COLUMNS};
    pub const CONTACT: usize = LAW_CONSTANTS;
    pub const INCREMENT: usize = CONTACT + NORMAL_COLUMNS;
    pub const HISTORY: usize = INCREMENT + 2;
    pub const RESULT: usize = HISTORY + MAX_HISTORY;
    pub const SLIDING: usize = RESULT + 7;
    pub const DISCARDS: usize = SLIDING + 1;
    pub const ALL: usize = DISCARDS + 1;
}

/// Columns of a call to a law of moments: constants, contact, spins, time step, history; then couple, dashpot, losses.
pub(super) mod moment_call {
    use super::{LAW_CONSTANTS, MAX_MOMENT_HISTORY, NORMAL_COLUMNS};
    pub const CONTACT: usize = LAW_CONSTANTS;
    pub const SPIN: usize = CONTACT + NORMAL_COLUMNS;
    pub const TIME_STEP: usize = SPIN + 3;
    pub const HISTORY: usize = TIME_STEP + 1;
    pub const RESULT: usize = HISTORY + MAX_MOMENT_HISTORY;
    pub const AT_LIMIT: usize = RESULT + 7;
    pub const ALL: usize = AT_LIMIT + 1;
}

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
            // The same bits, and no formula compiled that these lanes have no registers for.
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

/// Columns: constants, stiffness, history; the loss comes into the first.
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
        let numbers = [a, b, c, out.dashpot, out.work, out.loss, out.step_stiffness];
        write::<W, 7>(numbers, columns, RESULT);
        W::write_mask(out.at_limit, &mut columns[AT_LIMIT]);
    }
}

/// A normal law behind function pointers. Every [`NormalLaw`] is one.
pub trait NormalSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// What other laws may ask.
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
    /// [`NormalLaw::evaluate`] of one contact that touched.
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

/// A tangential law behind function pointers. Every [`TangentialLaw`] is one.
pub trait TangentialSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`TangentialLaw::goes_with`].
    ///
    /// # Errors
    /// The reason why it does not.
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str>;
    /// Columns of history, and how many plane vectors lead them.
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
    /// [`TangentialLaw::stiffness`] and [`TangentialLaw::step_stiffness`] of one contact.
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

/// A law of moments behind function pointers. Every [`MomentLaw`] is one.
pub trait MomentSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static Description;
    /// The type of the law.
    fn id(&self) -> TypeId;
    /// [`MomentLaw::ACTS`].
    fn acts(&self) -> bool;
    /// Columns of history, and how many plane vectors lead them.
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

/// A law that was chosen: a value to copy and compare; its name is its identity in files.
macro_rules! kind {
    ($kind:ident, $slot:ident, $law:ident, $what:literal, $($name:ident = $type:ident,)*) => {
        #[doc = concat!("Which ", $what, ". Its name is its identity in files.")]
        #[derive(Clone, Copy)]
        pub struct $kind(&'static dyn $slot);

        impl $kind {
            $(
                #[doc = concat!("[`", stringify!($type), "`].")]
                pub const $name: $kind = $kind(&$type);
            )*

            #[doc = concat!("The choice of a ", $what, ", which may be one of the caller's own.")]
            pub const fn new(law: &'static impl $law) -> $kind {
                $kind(law)
            }

            /// The law.
            pub fn law(&self) -> &'static dyn $slot {
                self.0
            }

            /// Its name in case files, e.g. `hertz`.
            pub fn name(&self) -> &'static str {
                self.0.description().name
            }

            /// Its name in reports.
            pub fn label(&self) -> &'static str {
                self.0.description().label
            }
        }

        impl PartialEq for $kind {
            fn eq(&self, other: &$kind) -> bool {
                self.0.id() == other.0.id() && self.name() == other.name()
            }
        }
        impl Eq for $kind {}
        impl Hash for $kind {
            fn hash<H: Hasher>(&self, state: &mut H) {
                self.name().hash(state);
            }
        }
        impl fmt::Debug for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
        impl fmt::Display for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
        impl serde::Serialize for $kind {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str(self.name())
            }
        }
    };
}

kind! {
    NormalKind, NormalSlot, NormalLaw, "normal law",
    HERTZ = Hertz,
    JKR = Jkr,
    HOOKE = Hooke,
}
kind! {
    TangentialKind, TangentialSlot, TangentialLaw, "tangential law",
    MINDLIN_DERESIEWICZ = MindlinDeresiewicz,
    NO_SLIP = NoSlip,
    PEELING = Peeling,
}
kind! {
    RollingKind, MomentSlot, MomentLaw, "law of the moments of a contact",
    NONE = NoMoments,
    ELASTIC_PLASTIC = ElasticPlasticRolling,
}
