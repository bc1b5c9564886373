//! The laws of a set together: compiled into one loop, or called one by one through their slots.

use std::marker::PhantomData;

use granum_simd::Real;

use crate::contact::adhesion::NoAdhesion;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::frame::Turn;
use crate::contact::evaluation::memory::{Memory, swap_sides};
use crate::contact::evaluation::steps::{adhesion_step, moment_step, normal_step, tangential_step};
use crate::contact::law::constants::{columns, named};
use crate::contact::law::energy_channel::{EnergyChannel, LAWS, LawEnergies, count};
use crate::contact::law::limits::{
    LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{
    AdhesionLaw, AdhesionLosses, Attraction, Moment, MomentLaw, Normal, NormalLaw, RelativeSpin, Tangential,
    TangentialLaw,
};
use crate::contact::rolling::NoMoments;

/// What [`crate::contact::evaluation::interaction::interact`] needs from the laws of a set. Histories are given as the previous step left them, and are
/// rotated into the present contact plane here.
pub trait LawSet<R: Real> {
    /// True if the set may have moments.
    const MAY_HAVE_MOMENTS: bool;
    /// True if the set may have a law of adhesion.
    const MAY_HAVE_ADHESION: bool;
    /// True if the set has moments.
    fn has_moments(&self) -> bool;
    /// True if the set has a law of adhesion.
    fn has_adhesion(&self) -> bool;
    /// True if a law of the set may have energy channels.
    const MAY_HAVE_CHANNELS: bool;
    /// True if a law of the set has energy channels.
    fn has_channels(&self) -> bool;
    /// Number of energy channels of the normal law, the tangential law, the moment law and the adhesion law.
    fn channels(&self) -> [usize; LAWS];
    /// A step of the normal law to an overlap: the contact, and the losses by making and breaking it, J.
    fn normal(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touched: R::Mask,
        history: &mut [R; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> (Normal<R>, AdhesionLosses<R>);
    /// A step of the tangential law, its stiffness for the time step, and the rotated force before the step.
    fn tangential(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        turn: &Turn<R>,
        history: &mut [R; MAX_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> (Tangential<R>, R, [R; 2]);
    /// A step of the moment law.
    fn moment(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        turn: &Turn<R>,
        history: &mut [R; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Moment<R>;
    /// A step of the law of adhesion.
    fn adhesion(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Attraction<R>;
}

/// Laws known when the program is compiled.
#[derive(Debug)]
pub struct Compiled<N, T, M = NoMoments, A = NoAdhesion>(PhantomData<(N, T, M, A)>);

impl<N, T, M, A> Compiled<N, T, M, A> {
    /// The set of these laws.
    pub const fn new() -> Self {
        Compiled(PhantomData)
    }
}
impl<N, T, M, A> Default for Compiled<N, T, M, A> {
    fn default() -> Self {
        Compiled::new()
    }
}
impl<N, T, M, A> Clone for Compiled<N, T, M, A> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}
impl<N, T, M, A> Copy for Compiled<N, T, M, A> {}

impl<N: NormalLaw, T: TangentialLaw, M: MomentLaw, A: AdhesionLaw> Compiled<N, T, M, A> {
    /// The constants of a pair; `parameters` of the four laws.
    pub fn constants(pair: &PairProperties, parameters: [&[f64]; 4]) -> PairConstants<f64> {
        let name = N::DESCRIPTION.name;
        let traits =
            crate::contact::NormalTraits { name, contact_area: N::CONTACT_AREA, adhesive: N::ADHESIVE };
        PairConstants {
            radius_sum: pair.radius_sum,
            inverse_radius_sum: 1.0 / pair.radius_sum,
            damping: 2.0 * pair.damping * pair.effective_mass.sqrt(),
            normal: columns(N::prepare(pair, parameters[0])),
            tangential: columns(T::prepare(pair, &traits, parameters[1])),
            rolling: columns(M::prepare(pair, parameters[2])),
            adhesion: columns(A::prepare(pair, parameters[3])),
        }
    }
}

impl<R: Real, N: NormalLaw, T: TangentialLaw, M: MomentLaw, A: AdhesionLaw> LawSet<R>
    for Compiled<N, T, M, A>
{
    const MAY_HAVE_MOMENTS: bool = M::ACTS;
    const MAY_HAVE_ADHESION: bool = A::ACTS;
    const MAY_HAVE_CHANNELS: bool =
        count(N::CHANNELS) + count(T::CHANNELS) + count(M::CHANNELS) + count(A::CHANNELS) > 0;
    #[inline(always)]
    fn has_channels(&self) -> bool {
        <Self as LawSet<R>>::MAY_HAVE_CHANNELS
    }
    #[inline(always)]
    fn channels(&self) -> [usize; LAWS] {
        [count(N::CHANNELS), count(T::CHANNELS), count(M::CHANNELS), count(A::CHANNELS)]
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        M::ACTS
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        A::ACTS
    }
    #[inline(always)]
    fn normal(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touched: R::Mask,
        history: &mut [R; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> (Normal<R>, AdhesionLosses<R>) {
        let constants = named(constants);
        let contact = normal_step::<R, N>(&constants, overlap, touched, history, energies);
        (contact, N::losses(&constants))
    }
    #[inline(always)]
    fn tangential(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        turn: &Turn<R>,
        history: &mut [R; MAX_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> (Tangential<R>, R, [R; 2]) {
        tangential_step::<R, T>(&named(constants), normal, increment, turn, history, energies)
    }
    #[inline(always)]
    fn moment(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        turn: &Turn<R>,
        history: &mut [R; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        moment_step::<R, M>(&named(constants), normal, spin, dt, turn, history, energies)
    }
    #[inline(always)]
    fn adhesion(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        adhesion_step::<R, A>(&named(constants), overlap, touching, history, energies)
    }
}

/// Functions of a set for a single contact.
impl ContactModel {
    /// True for a set of a normal and a tangential law only.
    pub(crate) fn has_contact_only(&self) -> bool {
        !self.rolling.law().acts() && !self.adhesion.law().acts()
    }

    /// Number of history columns of the tangential law, the moment law, the adhesion law and the normal law.
    pub(crate) fn history(&self) -> [usize; 4] {
        let [tangential, moments] = [self.tangential.law().history()[0], self.rolling.law().history()[0]];
        [tangential, moments, self.adhesion.law().history(), self.normal.law().history()]
    }

    /// The energy channels of the normal, the tangential, the moment and the adhesion law.
    pub fn channels(&self) -> [&'static [EnergyChannel]; LAWS] {
        let (normal, tangential) = (self.normal.law().channels(), self.tangential.law().channels());
        [normal, tangential, self.rolling.law().channels(), self.adhesion.law().channels()]
    }

    /// Number of values of [`PairConstants::to_array`] that the engine stores for a pair.
    pub(crate) fn constants_kept(&self) -> usize {
        PairConstants::kept(self.rolling.law().acts(), self.adhesion.law().acts())
    }

    /// The constants of a pair.
    pub fn constants(&self, pair: &PairProperties) -> PairConstants<f64> {
        let (normal, tangential, rolling) = (self.normal.law(), self.tangential.law(), self.rolling.law());
        let adhesion = self.adhesion.law();
        let values = |of: &'static crate::contact::LawDescription| self.parameters.resolved(of.parameters);
        PairConstants {
            radius_sum: pair.radius_sum,
            inverse_radius_sum: 1.0 / pair.radius_sum,
            damping: 2.0 * pair.damping * pair.effective_mass.sqrt(),
            normal: normal.prepare(pair, &values(normal.description())),
            tangential: tangential.prepare(pair, &normal.traits(), &values(tangential.description())),
            rolling: rolling.prepare(pair, &values(rolling.description())),
            adhesion: adhesion.prepare(pair, &values(adhesion.description())),
        }
    }

    /// The contact of a touching pair at a given overlap, m, without a history.
    pub fn normal_contact(&self, constants: &PairConstants<f64>, overlap: f64) -> Normal<f64> {
        self.normal.law().of_touching(&constants.normal, overlap, &[0.0; MAX_NORMAL_HISTORY])
    }

    /// Gives a pair that touches a bridge of the largest volume, if the law of adhesion shares liquid: for a pair alone, whose grains
    /// have enough of it.
    pub(crate) fn wet(&self, constants: &PairConstants<f64>, overlap: f64, memory: &mut Memory<f64>) {
        let law = self.adhesion.law();
        if law.shares_liquid() && overlap >= 0.0 {
            memory.adhesion = law.bridge(&constants.adhesion, law.largest_bridge(&constants.adhesion));
        }
    }

    /// Largest distance of the surfaces at which grains interact without touching, m.
    pub fn range(&self, constants: &PairConstants<f64>) -> f64 {
        self.adhesion.law().range(&constants.adhesion)
    }

    /// Overlap below which a touching pair breaks, m: zero without adhesion.
    pub fn breaking_overlap(&self, constants: &PairConstants<f64>) -> f64 {
        self.normal.law().breaking_overlap(&constants.normal)
    }

    /// Normal stiffness and the stiffness that limits the time step, N/m, of a contact under a load, N: an estimate before
    /// any contact exists.
    pub fn stiffness_under(&self, pair: &PairProperties, load: f64) -> [f64; 2] {
        let law = self.normal.law();
        let normal = law.loaded(pair, &self.parameters.resolved(law.description().parameters), load);
        let constants = self.constants(pair);
        let [_, step] = self.tangential.law().stiffness(&constants.tangential, &normal);
        let [_, attraction] = self.adhesion.law().at_touch(&constants.adhesion);
        [normal.stiffness, step + attraction / 3.0]
    }

    /// Rewrites a contact history for the pair (j, i) instead of (i, j).
    pub(crate) fn swap_sides(&self, memory: &mut Memory<f64>) {
        swap_sides(memory.normal, self.tangential.law().history()[1], &mut memory.history);
        swap_sides(memory.normal, self.rolling.law().history()[1], &mut memory.moments);
        memory.normal = memory.normal.map(|x| -x);
    }
}
