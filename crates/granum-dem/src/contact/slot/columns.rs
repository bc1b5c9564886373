//! Transfer of the numbers of contacts to a law that is called through a function pointer, and back.
//!
//! Constants and histories are read and written in place, in rows of eight; all other numbers are passed in the columns of a
//! [`Sheet`], from which one law reads the results of another.

use granum_simd::{LANES, Lanes, Real, Row8};

use crate::contact::law::Normal;
use crate::contact::law::constants::LawConstants;
use crate::contact::law::energy_channel::{EnergyChannel, LawEnergies};
use crate::contact::law::limits::{LAW_CHANNELS, LAW_CONSTANTS};

/// Number of contacts that a call evaluates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// One contact, in the first element of every row.
    One,
    /// One batch of eight.
    Batch,
}

/// Numbers that a call evaluates together, and their position in a row of eight.
pub trait Width {
    /// The numbers.
    type Value: Real;
    /// Their number.
    const COUNT: Count;
    /// Reads them.
    fn read(row: &Row8) -> Self::Value;
    /// Writes them.
    fn write(value: Self::Value, row: &mut Row8);
    /// Writes a mask as ones and zeros.
    #[inline(always)]
    fn write_mask(mask: <Self::Value as Real>::Mask, row: &mut Row8) {
        Self::write(Self::Value::splat(1.0).keep(mask), row);
    }
    /// Reads a mask written as ones and zeros.
    #[inline(always)]
    fn read_mask(row: &Row8) -> <Self::Value as Real>::Mask {
        Self::read(row).gt(Self::Value::zero())
    }
}

/// One contact, in plain numbers, or in those with the fused multiplications of the processor.
#[derive(Clone, Copy)]
pub struct One<R = f64>(std::marker::PhantomData<R>);
/// A batch.
#[derive(Clone, Copy)]
pub struct Batch<L>(std::marker::PhantomData<L>);

impl<R: Real> Width for One<R> {
    type Value = R;
    const COUNT: Count = Count::One;
    #[inline(always)]
    fn read(row: &Row8) -> R {
        R::splat(row.0[0])
    }
    #[inline(always)]
    fn write(value: R, row: &mut Row8) {
        row.0[0] = value.reduce_add();
    }
}
impl<L: Lanes> Width for Batch<L> {
    type Value = L;
    const COUNT: Count = Count::Batch;
    #[inline(always)]
    fn read(row: &Row8) -> L {
        L::load(&row.0)
    }
    #[inline(always)]
    fn write(value: L, row: &mut Row8) {
        value.store(&mut row.0);
    }
}

/// Reads consecutive columns.
#[inline(always)]
pub(super) fn read<W: Width, const N: usize>(columns: &Columns, from: usize) -> [W::Value; N] {
    std::array::from_fn(
        #[inline(always)]
        |c| W::read(&columns[from + c]),
    )
}

/// Writes consecutive columns.
#[inline(always)]
pub(super) fn write<W: Width, const N: usize>(values: [W::Value; N], columns: &mut Columns, from: usize) {
    for (c, value) in values.into_iter().enumerate() {
        W::write(value, &mut columns[from + c]);
    }
}

/// Columns through which the laws of a set and their caller pass numbers to each other.
pub(super) mod at {
    pub const OVERLAP: usize = 0;
    pub const TOUCHED: usize = 1;
    /// The normal part of a contact: the numbers of [`crate::contact::Normal`] and the mask of touching pairs.
    pub const CONTACT: usize = 2;
    pub const TOUCHING: usize = CONTACT + 7;
    /// Energy lost by making and by breaking.
    pub const LOSSES: usize = TOUCHING + 1;
    pub const INCREMENT: usize = LOSSES + 2;
    /// Cosine and sine of the rotation of stored vectors.
    pub const TURN: usize = INCREMENT + 2;
    /// Rolling, twisting, time step.
    pub const SPIN: usize = TURN + 2;
    /// Force before the step, force, stiffness, its root, losses, stiffness for the time step.
    pub const TANGENTIAL: usize = SPIN + 4;
    pub const SLIDING: usize = TANGENTIAL + 9;
    pub const DISCARDS: usize = SLIDING + 1;
    /// Couple, dashpots, work, loss, stiffness for the time step.
    pub const MOMENT: usize = DISCARDS + 1;
    pub const AT_LIMIT: usize = MOMENT + 8;
    /// Force, stiffness, loss.
    pub const ADHESION: usize = AT_LIMIT + 1;
    pub const ACTING: usize = ADHESION + 3;
    /// The energies in the channels of the law that was called last.
    pub const ENERGIES: usize = ACTING + 1;
    pub const ALL: usize = ENERGIES + super::LAW_CHANNELS;
}

/// The columns of a call.
pub(super) type Columns = [Row8; at::ALL];

/// The arguments of the call of a law: the constants and the history of a contact or of a batch, and the columns.
pub struct Sheet<'a> {
    pub(super) constants: &'a [Row8],
    pub(super) history: &'a mut [Row8],
    pub(super) columns: &'a mut Columns,
}

impl Sheet<'_> {
    /// The constants of the law.
    #[inline(always)]
    pub(super) fn constants<W: Width, C: LawConstants<W::Value>>(&self) -> C {
        let rows = &self.constants[..C::COUNT];
        C::take(
            0,
            #[inline(always)]
            |c| W::read(&rows[c]),
        )
    }

    /// Writes the energies in the channels of a law.
    #[inline(always)]
    pub(super) fn account<W: Width>(&mut self, energies: &LawEnergies<W::Value>, channels: &[EnergyChannel]) {
        for (k, energy) in energies.iter().enumerate().take(channels.len()) {
            W::write(*energy, &mut self.columns[at::ENERGIES + k]);
        }
    }

    /// The first columns of the history; the rest is zero.
    #[inline(always)]
    pub(super) fn history<W: Width, const N: usize>(&self, used: usize) -> [W::Value; N] {
        let mut history = [W::Value::zero(); N];
        for (value, row) in history.iter_mut().zip(&self.history[..used]) {
            *value = W::read(row);
        }
        history
    }

    /// Writes the first columns of the history.
    #[inline(always)]
    pub(super) fn keep<W: Width, const N: usize>(&mut self, history: &[W::Value; N], used: usize) {
        for (value, row) in history.iter().zip(&mut self.history[..used]) {
            W::write(*value, row);
        }
    }

    /// Calls for every contact of a batch, each in the first lane.
    pub(super) fn for_each_contact(&mut self, call: fn(&mut Sheet<'_>)) {
        let all = self.constants;
        for lane in 0..LANES {
            let mut constants = [Row8::default(); LAW_CONSTANTS];
            for (to, from) in constants.iter_mut().zip(all) {
                to.0[0] = from.0[lane];
            }
            self.bring_to_front(lane);
            call(&mut Sheet {
                constants: &constants,
                history: &mut *self.history,
                columns: &mut *self.columns,
            });
            self.bring_to_front(lane);
        }
    }

    /// Exchanges the contact of a lane with that of the first.
    fn bring_to_front(&mut self, lane: usize) {
        let rows = self.history.iter_mut().chain(self.columns.iter_mut());
        rows.for_each(|row| row.0.swap(0, lane));
    }
}

#[inline(always)]
pub(super) fn write_normal<W: Width>(normal: &Normal<W::Value>, columns: &mut Columns) {
    write::<W, 7>(normal.numbers(), columns, at::CONTACT);
    W::write_mask(normal.touching, &mut columns[at::TOUCHING]);
}

#[inline(always)]
pub(super) fn read_normal<W: Width>(columns: &Columns) -> Normal<W::Value> {
    Normal::from_numbers(read::<W, 7>(columns, at::CONTACT), W::read_mask(&columns[at::TOUCHING]))
}
