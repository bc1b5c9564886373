//! The laws as used by the contact stage: compiled into its loop, or called through their slots.

use granum_simd::{Lanes, Row8, Twice};

use super::views::Views;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::interaction::{Interaction, PairMotion, interact};
use crate::contact::evaluation::memory::Memory;
use crate::contact::evaluation::set::Compiled;
use crate::contact::law::constants::named;
use crate::contact::law::energy_channel::LAWS;
use crate::contact::law::limits::{LAW_CONSTANTS, MAX_HISTORY};
use crate::contact::law::{MomentLaw, NormalLaw, TangentialLaw};
use crate::contact::rolling::NoMoments;
use crate::contact::slot::columns::Batch;
use crate::contact::slot::slots::{InPlace, Slots};

/// Couples on the grains of a batch, or an empty type for sets that never have any, so that no memory is used for them.
pub(crate) trait Couples<L: Lanes>: Copy {
    /// No couples.
    fn none() -> Self;
    /// From the couples on the grains i, N m (the opposite couples act on the grains j), with the reciprocals of the radii of i and
    /// j, 1/m.
    fn from_couple(couple: [L; 3], inverse_radii: impl FnOnce() -> [L; 2]) -> Self;
    /// Torque over radius of i and of j, N, if any.
    fn moments(&self) -> Option<[[L; 3]; 2]>;
}

impl<L: Lanes> Couples<L> for () {
    #[inline(always)]
    fn none() {}
    #[inline(always)]
    fn from_couple(_couple: [L; 3], _inverse_radii: impl FnOnce() -> [L; 2]) {}
    #[inline(always)]
    fn moments(&self) -> Option<[[L; 3]; 2]> {
        None
    }
}

impl<L: Lanes> Couples<L> for [[L; 3]; 2] {
    #[inline(always)]
    fn none() -> Self {
        [[L::zero(); 3]; 2]
    }
    #[inline(always)]
    fn from_couple(couple: [L; 3], inverse_radii: impl FnOnce() -> [L; 2]) -> Self {
        let [x, y, z] = couple;
        let [i, j] = inverse_radii();
        [[x * i, y * i, z * i], [-(x * j), -(y * j), -(z * j)]]
    }
    #[inline(always)]
    fn moments(&self) -> Option<[[L; 3]; 2]> {
        Some(*self)
    }
}

/// The data of a batch: its rows of constants, if grains differ, and its history.
pub(crate) struct BatchData<'a> {
    pub(crate) views: &'a Views,
    pub(crate) batch: usize,
    pub(crate) history: &'a mut [Row8],
}

/// The laws of a contact stage.
pub(crate) trait StageLaws {
    /// True if the set may have moments.
    const MAY_HAVE_MOMENTS: bool;
    /// True if the set may have a law of adhesion.
    const MAY_HAVE_ADHESION: bool;
    /// True if a law of the set may have energy channels.
    const MAY_HAVE_CHANNELS: bool;
    /// True if [`StageLaws::interact`] advances the histories of the laws in place; otherwise it reads them from the [`Memory`] and
    /// writes them there, and two batches may be evaluated side by side. With calls to laws, whose numbers pass through memory, one
    /// batch after the other is faster.
    const IN_PLACE: bool;
    /// Type of the couples on grains.
    type Couples<L: Lanes>: Couples<L>;
    /// The laws of the simulation behind the views.
    fn from_views(views: &Views) -> Self;
    /// Number of history columns of the tangential law, the moment law, the adhesion law and the normal law.
    fn history(&self) -> [usize; 4];
    /// True if the set has moments.
    fn has_moments(&self) -> bool;
    /// True if the set has a law of adhesion.
    fn has_adhesion(&self) -> bool;
    /// True if the bridges of the law of adhesion share liquid with films on the grains.
    #[inline(always)]
    fn shares_liquid(&self) -> bool {
        false
    }
    /// True if a law of the set has energy channels.
    #[inline(always)]
    fn has_channels(&self) -> bool {
        false
    }
    /// Number of energy channels of the normal law, the tangential law, the moment law and the adhesion law.
    #[inline(always)]
    fn channels(&self) -> [usize; LAWS] {
        [0; LAWS]
    }
    /// True if the tangential law discards parts of its history that store energy.
    fn discards(&self) -> bool;
    /// One step of a batch.
    fn interact<L: Lanes>(
        &self,
        constants: &PairConstants<L>,
        kinematics: &PairMotion<L>,
        dt: L,
        memory: &mut Memory<L>,
        place: BatchData<'_>,
    ) -> Interaction<L>;
    /// One step of two batches; not for laws whose histories are advanced in place.
    fn interact_two<L: Lanes>(
        &self,
        constants: &PairConstants<Twice<L>>,
        kinematics: &PairMotion<Twice<L>>,
        dt: Twice<L>,
        memory: &mut Memory<Twice<L>>,
    ) -> Interaction<Twice<L>>;
    /// Energy lost with discarded parts of the histories, J.
    fn discarded<L: Lanes>(
        &self,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[L; MAX_HISTORY],
    ) -> L;
}

/// The type of the couples of a set with or without moments.
pub(crate) trait CouplesOf {
    type Couples<L: Lanes>: Couples<L>;
}
/// A set with moments, or without.
pub(crate) struct Choice<const MOMENTS: bool>;
impl CouplesOf for Choice<false> {
    type Couples<L: Lanes> = ();
}
impl CouplesOf for Choice<true> {
    type Couples<L: Lanes> = [[L; 3]; 2];
}

/// Laws that are compiled into the loop, with or without a law of moments.
pub(crate) struct InLoop<const MOMENTS: bool, N, T, M = NoMoments>(pub(crate) Compiled<N, T, M>);

impl<const MOMENTS: bool, N, T, M> StageLaws for InLoop<MOMENTS, N, T, M>
where
    N: NormalLaw,
    T: TangentialLaw,
    M: MomentLaw,
    Choice<MOMENTS>: CouplesOf,
{
    const MAY_HAVE_MOMENTS: bool = MOMENTS;
    const MAY_HAVE_ADHESION: bool = false;
    const MAY_HAVE_CHANNELS: bool = false;
    const IN_PLACE: bool = false;
    type Couples<L: Lanes> = <Choice<MOMENTS> as CouplesOf>::Couples<L>;
    #[inline(always)]
    fn from_views(_views: &Views) -> Self {
        const { assert!(N::HISTORY == 0 && M::ACTS == MOMENTS) };
        const { assert!(N::CHANNELS.is_empty() && T::CHANNELS.is_empty() && M::CHANNELS.is_empty()) };
        InLoop(Compiled::new())
    }
    #[inline(always)]
    fn history(&self) -> [usize; 4] {
        [T::HISTORY, M::HISTORY, 0, 0]
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        MOMENTS
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        false
    }
    #[inline(always)]
    fn discards(&self) -> bool {
        T::DISCARDS
    }
    #[inline(always)]
    fn interact<L: Lanes>(
        &self,
        constants: &PairConstants<L>,
        kinematics: &PairMotion<L>,
        dt: L,
        memory: &mut Memory<L>,
        _place: BatchData<'_>,
    ) -> Interaction<L> {
        interact(&self.0, constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn interact_two<L: Lanes>(
        &self,
        constants: &PairConstants<Twice<L>>,
        kinematics: &PairMotion<Twice<L>>,
        dt: Twice<L>,
        memory: &mut Memory<Twice<L>>,
    ) -> Interaction<Twice<L>> {
        interact(&self.0, constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn discarded<L: Lanes>(
        &self,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[L; MAX_HISTORY],
    ) -> L {
        T::discarded(&named(constants), stiffness, history)
    }
}

/// Any laws, called through their slots. With `MOMENTS` false a set must have none, and no memory is used for couples.
pub(crate) struct AnyLaws<const MOMENTS: bool> {
    slots: Slots,
    /// The constants of equal grains, in every lane.
    alike: [Row8; PairConstants::COUNT],
}

impl<const MOMENTS: bool> AnyLaws<MOMENTS> {
    /// The rows of constants of a batch.
    #[inline(always)]
    fn constants<'a>(&'a self, views: &'a Views, batch: usize) -> &'a [Row8] {
        if views.equal {
            return &self.alike;
        }
        let kept = views.constants_kept;
        // SAFETY: constants are only read.
        unsafe { &views.constants.read()[batch * kept..(batch + 1) * kept] }
    }
}

impl<const MOMENTS: bool> StageLaws for AnyLaws<MOMENTS>
where
    Choice<MOMENTS>: CouplesOf,
{
    const MAY_HAVE_MOMENTS: bool = MOMENTS;
    const MAY_HAVE_ADHESION: bool = true;
    const MAY_HAVE_CHANNELS: bool = true;
    const IN_PLACE: bool = true;
    type Couples<L: Lanes> = <Choice<MOMENTS> as CouplesOf>::Couples<L>;
    #[inline(always)]
    fn from_views(views: &Views) -> Self {
        AnyLaws {
            slots: Slots::new(&views.laws, views.isa),
            alike: views.alike.to_array().map(|value| Row8([value; 8])),
        }
    }
    #[inline(always)]
    fn history(&self) -> [usize; 4] {
        self.slots.history()
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        MOMENTS && self.slots.has_moments()
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        self.slots.has_adhesion()
    }
    #[inline(always)]
    fn shares_liquid(&self) -> bool {
        self.slots.shares_liquid()
    }
    #[inline(always)]
    fn has_channels(&self) -> bool {
        self.slots.has_channels()
    }
    #[inline(always)]
    fn channels(&self) -> [usize; LAWS] {
        self.slots.channels()
    }
    #[inline(always)]
    fn discards(&self) -> bool {
        self.slots.discards()
    }
    #[inline(always)]
    fn interact<L: Lanes>(
        &self,
        constants: &PairConstants<L>,
        kinematics: &PairMotion<L>,
        dt: L,
        memory: &mut Memory<L>,
        place: BatchData<'_>,
    ) -> Interaction<L> {
        let rows = self.constants(place.views, place.batch);
        let laws = InPlace::<Batch<L>, MOMENTS>::new(&self.slots, rows, place.history);
        interact(&laws, constants, kinematics, dt, memory)
    }
    #[inline(always)]
    fn interact_two<L: Lanes>(
        &self,
        _constants: &PairConstants<Twice<L>>,
        _kinematics: &PairMotion<Twice<L>>,
        _dt: Twice<L>,
        _memory: &mut Memory<Twice<L>>,
    ) -> Interaction<Twice<L>> {
        unreachable!("laws behind slots are evaluated batch by batch")
    }
    #[inline(always)]
    fn discarded<L: Lanes>(
        &self,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[L; MAX_HISTORY],
    ) -> L {
        self.slots.discarded::<Batch<L>>(constants, stiffness, history)
    }
}
