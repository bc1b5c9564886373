//! The laws of a set together: compiled into one loop, or called one by one through their slots.

use std::cell::RefCell;
use std::marker::PhantomData;

use granum_simd::{Isa, Real, Row8};

use super::adhesion::NoAdhesion;
use super::columns::{
    Column, Width, adhesion_call, moment_call, normal_call, read, read_normal, tangential_call, write,
    write_normal,
};
use super::interaction::Memory;
use super::law::{
    AdhesionLaw, AdhesionLosses, Attraction, Moment, MomentLaw, Normal, NormalLaw, RelativeSpin, Tangential,
    TangentialLaw, swap_sides,
};
use super::rolling::NoMoments;
use super::{
    LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, PairConstants, PairProperties,
};
use crate::config::Contact;

/// What [`super::interaction::interact`] needs from the laws of a set.
pub trait Laws<R: Real> {
    /// True if the set may have moments.
    const MAY_HAVE_MOMENTS: bool;
    /// True if the set may have a law of adhesion.
    const MAY_HAVE_ADHESION: bool;
    /// Number of history columns of the tangential law, and of plane vectors at their beginning.
    fn tangential_history(&self) -> [usize; 2];
    /// Number of history columns of the moment law, and of plane vectors at their beginning.
    fn moment_history(&self) -> [usize; 2];
    /// True if the set has moments.
    fn has_moments(&self) -> bool;
    /// True if the set has a law of adhesion.
    fn has_adhesion(&self) -> bool;
    /// The normal law at a given overlap.
    fn normal(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touched: R::Mask,
    ) -> (Normal<R>, AdhesionLosses<R>);
    /// A step of the tangential law, and its stiffness for the time step.
    fn tangential(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
    ) -> (Tangential<R>, R);
    /// A step of the moment law.
    fn moment(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
    ) -> Moment<R>;
    /// A step of the law of adhesion.
    fn adhesion(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
    ) -> Attraction<R>;
    /// Energy lost where a step of the tangential law discarded a part of the history, J.
    fn discarded(&self, constants: &[R; LAW_CONSTANTS], stiffness: R, history: &[R; MAX_HISTORY]) -> R;
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
        let traits = super::NormalTraits { name, contact_area: N::CONTACT_AREA, adhesive: N::ADHESIVE };
        PairConstants {
            radius_sum: pair.radius_sum,
            inverse_radius_sum: 1.0 / pair.radius_sum,
            damping: 2.0 * pair.damping * pair.effective_mass.sqrt(),
            normal: N::prepare(pair, parameters[0]),
            tangential: T::prepare(pair, &traits, parameters[1]),
            rolling: M::prepare(pair, parameters[2]),
            adhesion: A::prepare(pair, parameters[3]),
        }
    }
}

impl<R: Real, N: NormalLaw, T: TangentialLaw, M: MomentLaw, A: AdhesionLaw> Laws<R> for Compiled<N, T, M, A> {
    const MAY_HAVE_MOMENTS: bool = M::ACTS;
    const MAY_HAVE_ADHESION: bool = A::ACTS;
    #[inline(always)]
    fn tangential_history(&self) -> [usize; 2] {
        [T::HISTORY, T::PLANE_VECTORS]
    }
    #[inline(always)]
    fn moment_history(&self) -> [usize; 2] {
        [M::HISTORY, M::PLANE_VECTORS]
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
    ) -> (Normal<R>, AdhesionLosses<R>) {
        (N::evaluate(constants, overlap, touched), N::losses(constants))
    }
    #[inline(always)]
    fn tangential(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
    ) -> (Tangential<R>, R) {
        (T::update(constants, normal, increment, history), T::step_stiffness(constants, normal))
    }
    #[inline(always)]
    fn moment(
        &self,
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
    ) -> Moment<R> {
        M::update(constants, normal, spin, dt, history)
    }
    #[inline(always)]
    fn adhesion(
        &self,
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
    ) -> Attraction<R> {
        A::update(constants, overlap, touching, history)
    }
    #[inline(always)]
    fn discarded(&self, constants: &[R; LAW_CONSTANTS], stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        T::discarded(constants, stiffness, history)
    }
}

/// The slots of a set, with the working memory through which they are called.
pub struct Slots {
    laws: Contact,
    isa: Isa,
    tangential_history: [usize; 2],
    moment_history: [usize; 2],
    has_moments: bool,
    adhesion_history: usize,
    has_adhesion: bool,
    discards: bool,
    /// Every call first writes everything that it reads.
    columns: RefCell<[Column; MOST_COLUMNS]>,
}

const MOST_COLUMNS: usize = 40;
const _: () = assert!(normal_call::ALL <= MOST_COLUMNS && tangential_call::ALL <= MOST_COLUMNS);
const _: () = assert!(adhesion_call::ALL <= MOST_COLUMNS);
const _: () = assert!(moment_call::ALL <= MOST_COLUMNS && LAW_CONSTANTS + 1 + MAX_HISTORY <= MOST_COLUMNS);

impl Slots {
    /// The laws of a set for an instruction set.
    pub fn new(laws: &Contact, isa: Isa) -> Self {
        Slots {
            laws: *laws,
            isa,
            tangential_history: laws.tangential.law().history(),
            moment_history: laws.rolling.law().history(),
            has_moments: laws.rolling.law().acts(),
            adhesion_history: laws.adhesion.law().history(),
            has_adhesion: laws.adhesion.law().acts(),
            discards: laws.tangential.law().discards(),
            columns: RefCell::new([EMPTY; MOST_COLUMNS]),
        }
    }

    /// Number of history columns of the tangential law.
    #[inline(always)]
    pub(crate) fn tangential_columns(&self) -> usize {
        self.tangential_history[0]
    }

    /// Number of history columns of the moment law.
    #[inline(always)]
    pub(crate) fn moment_columns(&self) -> usize {
        self.moment_history[0]
    }

    /// True if the set has moments.
    #[inline(always)]
    pub(crate) fn has_moments(&self) -> bool {
        self.has_moments
    }

    /// Columns of history of the law of adhesion.
    #[inline(always)]
    pub(crate) fn adhesion_columns(&self) -> usize {
        self.adhesion_history
    }

    /// True if the set has a law of adhesion.
    #[inline(always)]
    pub(crate) fn has_adhesion(&self) -> bool {
        self.has_adhesion
    }

    /// True if the tangential law discards parts of its history that store energy.
    #[inline(always)]
    pub(crate) fn discards(&self) -> bool {
        self.discards
    }
}

/// Laws chosen at run time, each called through its slot, for contacts of the width `W`: one contact, or lanes of the
/// instruction set of the slots.
pub struct Open<'a, W> {
    slots: &'a Slots,
    width: PhantomData<W>,
}

impl<'a, W> Open<'a, W> {
    /// The laws of these slots.
    #[inline(always)]
    pub fn new(slots: &'a Slots) -> Self {
        Open { slots, width: PhantomData }
    }
}

const EMPTY: Column = [Row8([0.0; 8]); 2];

impl<W: Width> Laws<W::Value> for Open<'_, W> {
    const MAY_HAVE_MOMENTS: bool = true;
    const MAY_HAVE_ADHESION: bool = true;
    #[inline(always)]
    fn tangential_history(&self) -> [usize; 2] {
        self.slots.tangential_history
    }
    #[inline(always)]
    fn moment_history(&self) -> [usize; 2] {
        self.slots.moment_history
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        self.slots.has_moments
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        self.slots.has_adhesion
    }
    #[inline(always)]
    fn normal(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        overlap: W::Value,
        touched: <W::Value as Real>::Mask,
    ) -> (Normal<W::Value>, AdhesionLosses<W::Value>) {
        use normal_call::*;
        let columns = &mut self.slots.columns.borrow_mut()[..ALL];
        write::<W, LAW_CONSTANTS>(*constants, columns, 0);
        W::write(overlap, &mut columns[OVERLAP]);
        W::write_mask(touched, &mut columns[TOUCHED]);
        self.slots.laws.normal.law().evaluate(self.slots.isa, W::COUNT, columns);
        let [made, broken] = read::<W, 2>(columns, LOSSES);
        (read_normal::<W>(columns, CONTACT), AdhesionLosses { made, broken })
    }
    #[inline(always)]
    fn tangential(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        normal: &Normal<W::Value>,
        increment: [W::Value; 2],
        history: &mut [W::Value; MAX_HISTORY],
    ) -> (Tangential<W::Value>, W::Value) {
        use tangential_call::*;
        let columns = &mut self.slots.columns.borrow_mut()[..ALL];
        write::<W, LAW_CONSTANTS>(*constants, columns, 0);
        write_normal::<W>(normal, columns, CONTACT);
        write::<W, 2>(increment, columns, INCREMENT);
        let used = self.tangential_history()[0];
        for (c, value) in history.iter().enumerate().take(used) {
            W::write(*value, &mut columns[HISTORY + c]);
        }
        self.slots.laws.tangential.law().update(self.slots.isa, W::COUNT, columns);
        for (c, value) in history.iter_mut().enumerate().take(used) {
            *value = W::read(&columns[HISTORY + c]);
        }
        let [x, y, stiffness, root_stiffness, friction_loss, micro_slip_loss, step] =
            read::<W, 7>(columns, RESULT);
        let out = Tangential {
            force: [x, y],
            stiffness,
            root_stiffness,
            sliding: W::read_mask(&columns[SLIDING]),
            friction_loss,
            micro_slip_loss,
            discards: W::read_mask(&columns[DISCARDS]),
        };
        (out, step)
    }
    #[inline(always)]
    fn moment(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        normal: &Normal<W::Value>,
        spin: RelativeSpin<W::Value>,
        dt: W::Value,
        history: &mut [W::Value; MAX_MOMENT_HISTORY],
    ) -> Moment<W::Value> {
        use moment_call::*;
        if !self.has_moments() {
            return Moment::none();
        }
        let columns = &mut self.slots.columns.borrow_mut()[..ALL];
        write::<W, LAW_CONSTANTS>(*constants, columns, 0);
        write_normal::<W>(normal, columns, CONTACT);
        let [x, y] = spin.rolling;
        write::<W, 4>([x, y, spin.twisting, dt], columns, SPIN);
        write::<W, MAX_MOMENT_HISTORY>(*history, columns, HISTORY);
        self.slots.laws.rolling.law().update(self.slots.isa, W::COUNT, columns);
        *history = read::<W, MAX_MOMENT_HISTORY>(columns, HISTORY);
        let [a, b, c, dashpot, twisting_dashpot, work, loss, step_stiffness] = read::<W, 8>(columns, RESULT);
        let at_limit = W::read_mask(&columns[AT_LIMIT]);
        Moment { couple: [a, b, c], dashpot, twisting_dashpot, at_limit, work, loss, step_stiffness }
    }
    #[inline(always)]
    fn adhesion(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        overlap: W::Value,
        touching: <W::Value as Real>::Mask,
        history: &mut [W::Value; MAX_ADHESION_HISTORY],
    ) -> Attraction<W::Value> {
        use adhesion_call::*;
        if !self.has_adhesion() {
            return Attraction::none();
        }
        let columns = &mut self.slots.columns.borrow_mut()[..ALL];
        write::<W, LAW_CONSTANTS>(*constants, columns, 0);
        W::write(overlap, &mut columns[OVERLAP]);
        W::write_mask(touching, &mut columns[TOUCHING]);
        write::<W, MAX_ADHESION_HISTORY>(*history, columns, HISTORY);
        self.slots.laws.adhesion.law().update(self.slots.isa, W::COUNT, columns);
        *history = read::<W, MAX_ADHESION_HISTORY>(columns, HISTORY);
        let [force, stiffness, loss] = read::<W, 3>(columns, RESULT);
        Attraction { force, stiffness, acting: W::read_mask(&columns[ACTING]), loss }
    }
    #[inline(always)]
    fn discarded(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        stiffness: W::Value,
        history: &[W::Value; MAX_HISTORY],
    ) -> W::Value {
        let columns = &mut self.slots.columns.borrow_mut()[..LAW_CONSTANTS + 1 + MAX_HISTORY];
        write::<W, LAW_CONSTANTS>(*constants, columns, 0);
        W::write(stiffness, &mut columns[LAW_CONSTANTS]);
        write::<W, MAX_HISTORY>(*history, columns, LAW_CONSTANTS + 1);
        self.slots.laws.tangential.law().discarded(self.slots.isa, W::COUNT, columns);
        W::read(&columns[0])
    }
}

/// What the engine needs from a set for a single contact.
impl Contact {
    /// True for a set of a normal and a tangential law with nothing beside them.
    pub(crate) fn has_contact_only(&self) -> bool {
        !self.rolling.law().acts() && !self.adhesion.law().acts()
    }

    /// Columns of history: of the tangential law, of the law of moments, of the law of adhesion.
    pub(crate) fn history(&self) -> [usize; 3] {
        let [tangential, moments] = [self.tangential.law().history()[0], self.rolling.law().history()[0]];
        [tangential, moments, self.adhesion.law().history()]
    }

    /// Number of values of [`PairConstants::to_array`] that the engine stores for a pair.
    pub(crate) fn constants_kept(&self) -> usize {
        PairConstants::kept(self.rolling.law().acts(), self.adhesion.law().acts())
    }

    /// The constants of a pair.
    pub fn constants(&self, pair: &PairProperties) -> PairConstants<f64> {
        let (normal, tangential, rolling) = (self.normal.law(), self.tangential.law(), self.rolling.law());
        let adhesion = self.adhesion.law();
        let values = |of: &'static super::Description| self.parameters.resolved(of.parameters);
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

    /// The contact of a touching pair at a given overlap, m.
    pub fn normal_contact(&self, constants: &PairConstants<f64>, overlap: f64) -> Normal<f64> {
        self.normal.law().of_touching(&constants.normal, overlap)
    }

    /// Elastic energy of the overlap, J.
    pub fn normal_energy(&self, constants: &PairConstants<f64>, overlap: f64) -> f64 {
        self.normal.law().energy(&constants.normal, overlap)
    }

    /// Elastic energy of the tangential displacement, J.
    pub(crate) fn tangential_energy(
        &self,
        constants: &PairConstants<f64>,
        normal: &Normal<f64>,
        memory: &Memory<f64>,
    ) -> f64 {
        let law = self.tangential.law();
        let [stiffness, _] = law.stiffness(&constants.tangential, normal);
        law.energy(&constants.tangential, stiffness, &memory.history)
    }

    /// Elastic energy of rolling and twisting, J.
    pub(crate) fn moment_energy(&self, constants: &PairConstants<f64>, memory: &Memory<f64>) -> f64 {
        self.rolling.law().energy(&constants.rolling, &memory.moments)
    }

    /// Attraction beside the contact at an overlap, m, with this memory, N.
    pub(crate) fn attraction(
        &self,
        constants: &PairConstants<f64>,
        overlap: f64,
        touching: bool,
        memory: &Memory<f64>,
    ) -> f64 {
        self.adhesion.law().force(&constants.adhesion, overlap, touching, &memory.adhesion)
    }

    /// Energy of that attraction, J.
    pub(crate) fn attraction_energy(
        &self,
        constants: &PairConstants<f64>,
        overlap: f64,
        memory: &Memory<f64>,
    ) -> f64 {
        self.adhesion.law().energy(&constants.adhesion, overlap, &memory.adhesion)
    }

    /// Largest distance of the surfaces at which grains that do not touch act on each other, m.
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
