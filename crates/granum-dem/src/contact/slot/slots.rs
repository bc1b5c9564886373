//! The laws of a set called one by one through their slots.

use std::cell::RefCell;
use std::marker::PhantomData;

use granum_simd::{Isa, Real, Row8};

use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::frame::Turn;
use crate::contact::evaluation::set::LawSet;
use crate::contact::law::energy_channel::{LAWS, LawEnergies};
use crate::contact::law::limits::{
    LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::law::{AdhesionLosses, Attraction, Moment, Normal, RelativeSpin, Tangential};
use crate::contact::slot::columns::{
    Columns, Count, Sheet, Width, at, read, read_normal, write, write_normal,
};
use crate::contact::slot::entry::Entry;

/// Columns of the history of a contact before those of the laws: the old normal.
pub(crate) const DIRECTION: usize = 3;

/// The computations of the laws of a set.
#[derive(Clone, Copy)]
struct Entries {
    normal: Entry,
    tangential: Entry,
    discarded: Entry,
    moment: Entry,
    adhesion: Entry,
}

impl Entries {
    fn new(laws: &ContactModel, isa: Isa, count: Count) -> Entries {
        let tangential = laws.tangential.law();
        Entries {
            normal: laws.normal.law().evaluate(isa, count),
            tangential: tangential.update(isa, count),
            discarded: tangential.discarded(isa, count),
            moment: laws.rolling.law().update(isa, count),
            adhesion: laws.adhesion.law().update(isa, count),
        }
    }
}

/// The slots of a set, with the working memory through which they are called.
pub struct Slots {
    /// For one contact, and for a batch.
    entries: [Entries; 2],
    /// Number of history columns of the tangential law, the moment law, the adhesion law and the normal law.
    history: [usize; 4],
    has_moments: bool,
    has_adhesion: bool,
    shares_liquid: bool,
    discards: bool,
    /// Number of energy channels of each law.
    channels: [usize; LAWS],
    has_channels: bool,
    columns: RefCell<Columns>,
}

const EMPTY: Row8 = Row8([0.0; 8]);

impl Slots {
    /// The laws of a set for an instruction set.
    pub fn new(laws: &ContactModel, isa: Isa) -> Self {
        Slots {
            entries: [Count::One, Count::Batch].map(|count| Entries::new(laws, isa, count)),
            history: laws.history(),
            has_moments: laws.rolling.law().acts(),
            has_adhesion: laws.adhesion.law().acts(),
            shares_liquid: laws.adhesion.law().shares_liquid(),
            discards: laws.tangential.law().discards(),
            channels: laws.channels().map(<[_]>::len),
            has_channels: laws.channels().iter().any(|channels| !channels.is_empty()),
            columns: RefCell::new([EMPTY; at::ALL]),
        }
    }

    #[inline(always)]
    fn entries<W: Width>(&self) -> &Entries {
        &self.entries[W::COUNT as usize]
    }

    /// Number of history columns of the tangential law, the moment law, the adhesion law and the normal law.
    #[inline(always)]
    pub(crate) fn history(&self) -> [usize; 4] {
        self.history
    }

    /// True if the set has a law of moments.
    #[inline(always)]
    pub(crate) fn has_moments(&self) -> bool {
        self.has_moments
    }

    /// True if the set has a law of adhesion.
    #[inline(always)]
    pub(crate) fn has_adhesion(&self) -> bool {
        self.has_adhesion
    }

    /// True if the bridges of the law of adhesion share liquid with films on the grains.
    #[inline(always)]
    pub(crate) fn shares_liquid(&self) -> bool {
        self.shares_liquid
    }

    /// Number of energy channels of the normal law, the tangential law, the moment law and the adhesion law.
    #[inline(always)]
    pub(crate) fn channels(&self) -> [usize; LAWS] {
        self.channels
    }

    /// True if a law of the set has energy channels.
    #[inline(always)]
    pub(crate) fn has_channels(&self) -> bool {
        self.has_channels
    }

    /// True if the tangential law discards parts of its history that store energy.
    #[inline(always)]
    pub(crate) fn discards(&self) -> bool {
        self.discards
    }

    /// Energy lost where a step of the tangential law discarded a part of the history, J.
    #[inline(always)]
    pub(crate) fn discarded<W: Width>(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        stiffness: W::Value,
        history: &[W::Value; MAX_HISTORY],
    ) -> W::Value {
        let rows = Rows::<LAW_CONSTANTS>::from_values::<W>(constants);
        let mut past = Rows::<MAX_HISTORY>::from_values::<W>(history);
        let columns = &mut *self.columns.borrow_mut();
        W::write(stiffness, &mut columns[0]);
        let mut sheet = Sheet { constants: &rows.0, history: &mut past.0, columns };
        self.entries::<W>().discarded.call(&mut sheet);
        W::read(&sheet.columns[0])
    }
}

/// Numbers of one contact or of a batch, by rows.
struct Rows<const N: usize>([Row8; N]);

impl<const N: usize> Rows<N> {
    #[inline(always)]
    fn from_values<W: Width>(values: &[W::Value; N]) -> Self {
        let mut rows = Rows([EMPTY; N]);
        for (value, row) in values.iter().zip(&mut rows.0) {
            W::write(*value, row);
        }
        rows
    }

    #[inline(always)]
    fn values<W: Width>(&self) -> [W::Value; N] {
        std::array::from_fn(
            #[inline(always)]
            |c| W::read(&self.0[c]),
        )
    }
}

/// LawSet chosen at run time, each called through its slot, for contacts of the width `W`: one contact, or lanes of the
/// instruction set of the slots. Constants and histories are copied into rows for the call, and the histories back.
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

impl<W: Width> Open<'_, W> {
    /// Calls a slot with its constants and its history, and returns its results from the columns.
    #[inline(always)]
    fn with<const N: usize, T>(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        history: &mut [W::Value; N],
        call: impl FnOnce(&mut Sheet<'_>) -> T,
    ) -> T {
        let rows = Rows::<LAW_CONSTANTS>::from_values::<W>(constants);
        let mut past = Rows::<N>::from_values::<W>(history);
        let columns = &mut *self.slots.columns.borrow_mut();
        let out = call(&mut Sheet { constants: &rows.0, history: &mut past.0, columns });
        *history = past.values::<W>();
        out
    }
}

impl<W: Width> LawSet<W::Value> for Open<'_, W> {
    const MAY_HAVE_MOMENTS: bool = true;
    const MAY_HAVE_ADHESION: bool = true;
    const MAY_HAVE_CHANNELS: bool = true;
    #[inline(always)]
    fn has_channels(&self) -> bool {
        self.slots.has_channels()
    }
    #[inline(always)]
    fn channels(&self) -> [usize; LAWS] {
        self.slots.channels()
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
        history: &mut [W::Value; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> (Normal<W::Value>, AdhesionLosses<W::Value>) {
        self.with(constants, history, |sheet| normal::<W>(self.slots, sheet, overlap, touched, energies))
    }
    #[inline(always)]
    fn tangential(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        normal: &Normal<W::Value>,
        increment: [W::Value; 2],
        turn: &Turn<W::Value>,
        history: &mut [W::Value; MAX_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> (Tangential<W::Value>, W::Value, [W::Value; 2]) {
        self.with(constants, history, |sheet| {
            write_normal::<W>(normal, sheet.columns);
            tangential::<W>(self.slots, sheet, increment, turn, energies)
        })
    }
    #[inline(always)]
    fn moment(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        normal: &Normal<W::Value>,
        spin: RelativeSpin<W::Value>,
        dt: W::Value,
        turn: &Turn<W::Value>,
        history: &mut [W::Value; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> Moment<W::Value> {
        self.with(constants, history, |sheet| {
            write_normal::<W>(normal, sheet.columns);
            moment::<W>(self.slots, sheet, spin, dt, turn, energies)
        })
    }
    #[inline(always)]
    fn adhesion(
        &self,
        constants: &[W::Value; LAW_CONSTANTS],
        overlap: W::Value,
        touching: <W::Value as Real>::Mask,
        history: &mut [W::Value; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> Attraction<W::Value> {
        self.with(constants, history, |sheet| adhesion::<W>(self.slots, sheet, overlap, touching, energies))
    }
}

/// The same for a batch of the engine, whose constants and histories are used in place. The normal law must be called first:
/// the others read the state of the contact that it wrote to the columns.
pub(crate) struct InPlace<'a, 'b, W, const MOMENTS: bool> {
    slots: &'a Slots,
    constants: &'b [Row8],
    history: RefCell<&'b mut [Row8]>,
    width: PhantomData<W>,
}

/// First constants of the laws among those of a pair.
const NORMAL_CONSTANTS: usize = 3;
const TANGENTIAL_CONSTANTS: usize = NORMAL_CONSTANTS + LAW_CONSTANTS;

impl<'a, 'b, W: Width, const MOMENTS: bool> InPlace<'a, 'b, W, MOMENTS> {
    /// The laws of these slots for a batch with these rows of constants and of history.
    #[inline(always)]
    pub(crate) fn new(slots: &'a Slots, constants: &'b [Row8], history: &'b mut [Row8]) -> Self {
        InPlace { slots, constants, history: RefCell::new(history), width: PhantomData }
    }

    #[inline(always)]
    fn with<T>(&self, constants: usize, history: usize, call: impl FnOnce(&mut Sheet<'_>) -> T) -> T {
        call(&mut Sheet {
            constants: &self.constants[constants..],
            history: &mut self.history.borrow_mut()[history..],
            columns: &mut self.slots.columns.borrow_mut(),
        })
    }
}

impl<W: Width, const MOMENTS: bool> LawSet<W::Value> for InPlace<'_, '_, W, MOMENTS> {
    const MAY_HAVE_MOMENTS: bool = MOMENTS;
    const MAY_HAVE_ADHESION: bool = true;
    const MAY_HAVE_CHANNELS: bool = true;
    #[inline(always)]
    fn has_channels(&self) -> bool {
        self.slots.has_channels()
    }
    #[inline(always)]
    fn channels(&self) -> [usize; LAWS] {
        self.slots.channels()
    }
    #[inline(always)]
    fn has_moments(&self) -> bool {
        MOMENTS && self.slots.has_moments
    }
    #[inline(always)]
    fn has_adhesion(&self) -> bool {
        self.slots.has_adhesion
    }
    #[inline(always)]
    fn normal(
        &self,
        _constants: &[W::Value; LAW_CONSTANTS],
        overlap: W::Value,
        touched: <W::Value as Real>::Mask,
        _history: &mut [W::Value; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> (Normal<W::Value>, AdhesionLosses<W::Value>) {
        let [tangential, moments, adhesion, _] = self.slots.history;
        self.with(
            NORMAL_CONSTANTS,
            DIRECTION + tangential + moments + adhesion,
            #[inline(always)]
            |sheet| normal::<W>(self.slots, sheet, overlap, touched, energies),
        )
    }
    #[inline(always)]
    fn tangential(
        &self,
        _constants: &[W::Value; LAW_CONSTANTS],
        _normal: &Normal<W::Value>,
        increment: [W::Value; 2],
        turn: &Turn<W::Value>,
        _history: &mut [W::Value; MAX_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> (Tangential<W::Value>, W::Value, [W::Value; 2]) {
        self.with(
            TANGENTIAL_CONSTANTS,
            DIRECTION,
            #[inline(always)]
            |sheet| tangential::<W>(self.slots, sheet, increment, turn, energies),
        )
    }
    #[inline(always)]
    fn moment(
        &self,
        _constants: &[W::Value; LAW_CONSTANTS],
        _normal: &Normal<W::Value>,
        spin: RelativeSpin<W::Value>,
        dt: W::Value,
        turn: &Turn<W::Value>,
        _history: &mut [W::Value; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> Moment<W::Value> {
        self.with(
            PairConstants::WITHOUT_MOMENTS,
            DIRECTION + self.slots.history[0],
            #[inline(always)]
            |sheet| moment::<W>(self.slots, sheet, spin, dt, turn, energies),
        )
    }
    #[inline(always)]
    fn adhesion(
        &self,
        _constants: &[W::Value; LAW_CONSTANTS],
        overlap: W::Value,
        touching: <W::Value as Real>::Mask,
        _history: &mut [W::Value; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<W::Value>,
    ) -> Attraction<W::Value> {
        let [tangential, moments, ..] = self.slots.history;
        self.with(
            PairConstants::WITHOUT_ADHESION,
            DIRECTION + tangential + moments,
            #[inline(always)]
            |sheet| adhesion::<W>(self.slots, sheet, overlap, touching, energies),
        )
    }
}

/// Reads what the law that was called last put into its channels; `law` is its number in the set.
#[inline(always)]
fn accounted<W: Width>(slots: &Slots, law: usize, columns: &Columns, energies: &mut LawEnergies<W::Value>) {
    if !slots.has_channels {
        return;
    }
    for (k, energy) in energies.iter_mut().enumerate() {
        if k < slots.channels[law] {
            *energy = W::read(&columns[at::ENERGIES + k]);
        }
    }
}

#[inline(always)]
fn normal<W: Width>(
    slots: &Slots,
    sheet: &mut Sheet<'_>,
    overlap: W::Value,
    touched: <W::Value as Real>::Mask,
    energies: &mut LawEnergies<W::Value>,
) -> (Normal<W::Value>, AdhesionLosses<W::Value>) {
    W::write(overlap, &mut sheet.columns[at::OVERLAP]);
    W::write_mask(touched, &mut sheet.columns[at::TOUCHED]);
    slots.entries::<W>().normal.call(sheet);
    accounted::<W>(slots, 0, sheet.columns, energies);
    let [made, broken] = read::<W, 2>(sheet.columns, at::LOSSES);
    (read_normal::<W>(sheet.columns), AdhesionLosses { made, broken })
}

#[inline(always)]
fn tangential<W: Width>(
    slots: &Slots,
    sheet: &mut Sheet<'_>,
    increment: [W::Value; 2],
    turn: &Turn<W::Value>,
    energies: &mut LawEnergies<W::Value>,
) -> (Tangential<W::Value>, W::Value, [W::Value; 2]) {
    write::<W, 4>([increment[0], increment[1], turn.cosine, turn.sine], sheet.columns, at::INCREMENT);
    slots.entries::<W>().tangential.call(sheet);
    accounted::<W>(slots, 1, sheet.columns, energies);
    let columns = &*sheet.columns;
    let [u, v, x, y, stiffness, root_stiffness, friction_loss, micro_slip_loss, step] =
        read::<W, 9>(columns, at::TANGENTIAL);
    let out = Tangential {
        force: [x, y],
        stiffness,
        root_stiffness,
        sliding: W::read_mask(&columns[at::SLIDING]),
        friction_loss,
        micro_slip_loss,
        discards: W::read_mask(&columns[at::DISCARDS]),
    };
    (out, step, [u, v])
}

#[inline(always)]
fn moment<W: Width>(
    slots: &Slots,
    sheet: &mut Sheet<'_>,
    spin: RelativeSpin<W::Value>,
    dt: W::Value,
    turn: &Turn<W::Value>,
    energies: &mut LawEnergies<W::Value>,
) -> Moment<W::Value> {
    if !slots.has_moments {
        return Moment::none();
    }
    let [x, y] = spin.rolling;
    write::<W, 6>([turn.cosine, turn.sine, x, y, spin.twisting, dt], sheet.columns, at::TURN);
    slots.entries::<W>().moment.call(sheet);
    accounted::<W>(slots, 2, sheet.columns, energies);
    let columns = &*sheet.columns;
    let [a, b, c, dashpot, twisting_dashpot, work, loss, step_stiffness] = read::<W, 8>(columns, at::MOMENT);
    let at_limit = W::read_mask(&columns[at::AT_LIMIT]);
    Moment { couple: [a, b, c], dashpot, twisting_dashpot, at_limit, work, loss, step_stiffness }
}

#[inline(always)]
fn adhesion<W: Width>(
    slots: &Slots,
    sheet: &mut Sheet<'_>,
    overlap: W::Value,
    touching: <W::Value as Real>::Mask,
    energies: &mut LawEnergies<W::Value>,
) -> Attraction<W::Value> {
    if !slots.has_adhesion {
        return Attraction::none();
    }
    W::write(overlap, &mut sheet.columns[at::OVERLAP]);
    W::write_mask(touching, &mut sheet.columns[at::TOUCHING]);
    slots.entries::<W>().adhesion.call(sheet);
    accounted::<W>(slots, 3, sheet.columns, energies);
    let [force, stiffness, loss] = read::<W, 3>(sheet.columns, at::ADHESION);
    Attraction { force, stiffness, acting: W::read_mask(&sheet.columns[at::ACTING]), loss }
}
