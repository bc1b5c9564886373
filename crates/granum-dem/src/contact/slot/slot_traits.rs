//! A law behind function pointers.
//!
//! A law is written over any lanes ([`NormalLaw`] and so on). A slot is such a law behind one function pointer that is
//! called once for a batch of eight contacts; the numbers are passed through memory ([`Sheet`](super::columns::Sheet)). Each law is thus
//! compiled once for an instruction set, whatever laws it is combined with, and a program outside this workspace can add its
//! own.

use std::any::TypeId;

use granum_simd::Isa;

use super::calls::{AdhesionCall, DiscardedCall, MomentCall, NormalCall, TangentialCall, no_energies};
use super::columns::Count;
use super::entry::Entry;
use crate::contact::evaluation::observed::{self, ObservedBatch};
use crate::contact::law::constants::{columns, named};
use crate::contact::law::description::LawDescription;
use crate::contact::law::energy_channel::{EnergyChannel, count};
use crate::contact::law::limits::{
    LAW_CHANNELS, LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{AdhesionLaw, MomentLaw, Normal, NormalLaw, NormalTraits, TangentialLaw};

/// A normal law behind function pointers. Every [`NormalLaw`] implements it.
pub trait NormalSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static LawDescription;
    /// Properties that other laws depend on.
    fn traits(&self) -> NormalTraits;
    /// Its energy channels.
    fn channels(&self) -> &'static [EnergyChannel];
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
    fn description(&self) -> &'static LawDescription {
        &N::DESCRIPTION
    }
    fn traits(&self) -> NormalTraits {
        let name = N::DESCRIPTION.name;
        NormalTraits { name, contact_area: N::CONTACT_AREA, adhesive: N::ADHESIVE }
    }
    fn channels(&self) -> &'static [EnergyChannel] {
        const { assert!(count(N::CHANNELS) <= LAW_CHANNELS) };
        N::CHANNELS
    }
    fn id(&self) -> TypeId {
        TypeId::of::<N>()
    }
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        columns(N::prepare(pair, parameters))
    }
    fn history(&self) -> usize {
        N::HISTORY
    }
    fn evaluate(&self, isa: Isa, count: Count) -> Entry {
        Entry::new::<NormalCall<N>>(isa, count)
    }
    fn loaded(&self, pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        N::loaded(pair, parameters, load)
    }
    fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]) {
        observed::normal::<N>(isa, contacts);
    }
    fn breaking_overlap(&self, constants: &[f64; LAW_CONSTANTS]) -> f64 {
        N::breaking_overlap(&named(constants))
    }
    fn of_touching(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        history: &[f64; MAX_NORMAL_HISTORY],
    ) -> Normal<f64> {
        N::update(&named(constants), overlap, true, &mut { *history }, &mut no_energies())
    }
}

/// A tangential law behind function pointers. Every [`TangentialLaw`] implements it.
pub trait TangentialSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static LawDescription;
    /// Its energy channels.
    fn channels(&self) -> &'static [EnergyChannel];
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
    fn description(&self) -> &'static LawDescription {
        &T::DESCRIPTION
    }
    fn channels(&self) -> &'static [EnergyChannel] {
        const { assert!(count(T::CHANNELS) <= LAW_CHANNELS) };
        T::CHANNELS
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
        columns(T::prepare(pair, normal, parameters))
    }
    fn update(&self, isa: Isa, count: Count) -> Entry {
        Entry::new::<TangentialCall<T>>(isa, count)
    }
    fn discarded(&self, isa: Isa, count: Count) -> Entry {
        if T::DISCARDS { Entry::new::<DiscardedCall<T>>(isa, count) } else { Entry::none() }
    }
    fn stiffness(&self, constants: &[f64; LAW_CONSTANTS], normal: &Normal<f64>) -> [f64; 2] {
        let constants = named(constants);
        [T::stiffness(&constants, normal), T::step_stiffness(&constants, normal)]
    }
    fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]) {
        observed::tangential::<T>(isa, contacts);
    }
}

/// A moment law behind function pointers. Every [`MomentLaw`] implements it.
pub trait MomentSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static LawDescription;
    /// Its energy channels.
    fn channels(&self) -> &'static [EnergyChannel];
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
    fn description(&self) -> &'static LawDescription {
        &M::DESCRIPTION
    }
    fn channels(&self) -> &'static [EnergyChannel] {
        const { assert!(count(M::CHANNELS) <= LAW_CHANNELS) };
        M::CHANNELS
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
        columns(M::prepare(pair, parameters))
    }
    fn update(&self, isa: Isa, count: Count) -> Entry {
        if M::ACTS { Entry::new::<MomentCall<M>>(isa, count) } else { Entry::none() }
    }
    fn energy(&self, constants: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        M::energy(&named(constants), history)
    }
}

/// An adhesion law behind function pointers. Every [`AdhesionLaw`] implements it.
pub trait AdhesionSlot: Send + Sync {
    /// Name, label, help and parameters.
    fn description(&self) -> &'static LawDescription;
    /// Its energy channels.
    fn channels(&self) -> &'static [EnergyChannel];
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
    fn description(&self) -> &'static LawDescription {
        &A::DESCRIPTION
    }
    fn channels(&self) -> &'static [EnergyChannel] {
        const { assert!(count(A::CHANNELS) <= LAW_CHANNELS) };
        A::CHANNELS
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
        A::largest_bridge(&named(constants))
    }
    fn bridge(&self, constants: &[f64; LAW_CONSTANTS], volume: f64) -> [f64; MAX_ADHESION_HISTORY] {
        A::bridge(&named(constants), volume)
    }
    fn goes_with(&self, normal: &NormalTraits) -> Result<(), &'static str> {
        A::goes_with(normal)
    }
    fn history(&self) -> usize {
        A::HISTORY
    }
    fn prepare(&self, pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        columns(A::prepare(pair, parameters))
    }
    fn update(&self, isa: Isa, count: Count) -> Entry {
        if A::ACTS { Entry::new::<AdhesionCall<A>>(isa, count) } else { Entry::none() }
    }
    fn at_touch(&self, constants: &[f64; LAW_CONSTANTS]) -> [f64; 2] {
        let constants = named(constants);
        let mut history = match A::SHARES_LIQUID {
            true => A::bridge(&constants, A::largest_bridge(&constants)),
            false => [0.0; MAX_ADHESION_HISTORY],
        };
        let out = A::update(&constants, 0.0, true, &mut history, &mut no_energies());
        [out.force, out.stiffness]
    }
    fn force(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        touching: bool,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        A::update(&named(constants), overlap, touching, &mut { *history }, &mut no_energies()).force
    }
    fn energy(
        &self,
        constants: &[f64; LAW_CONSTANTS],
        overlap: f64,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        A::energy(&named(constants), overlap, history)
    }
    fn range(&self, constants: &[f64; LAW_CONSTANTS]) -> f64 {
        A::range(&named(constants))
    }
}
