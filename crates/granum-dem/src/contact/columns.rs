//! Transfer of the numbers of contacts to a law that is called through a function pointer, and back.
//!
//! Constants and histories are read and written in place, in rows of eight; all other numbers are passed in the columns of a
//! [`Sheet`], from which one law reads the results of another.

use granum_simd::{LANES, Lanes, Real, Row8, Twice};

use super::law::Normal;
use crate::contact::limits::LAW_CONSTANTS;

/// One number of a contact, for up to two batches of eight contacts.
pub type Column = [Row8; 2];

/// Number of contacts that a call evaluates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// One contact, in the first element of every column.
    One,
    /// One batch of eight.
    Batch,
    /// Two batches.
    TwoBatches,
}

/// Numbers that a call evaluates together, and their position in a column.
pub trait Width {
    /// The numbers.
    type Value: Real;
    /// Their number.
    const COUNT: Count;
    /// Reads them from a column.
    fn read(column: &Column) -> Self::Value;
    /// Writes them to a column.
    fn write(value: Self::Value, column: &mut Column);
    /// Reads them from row `c` of each batch; one batch is the first.
    fn read_rows(rows: [&[Row8]; 2], c: usize) -> Self::Value;
    /// Writes them to row `c` of each batch.
    fn write_rows(value: Self::Value, rows: &mut [&mut [Row8]; 2], c: usize);
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
    #[inline(always)]
    fn read_rows(rows: [&[Row8]; 2], c: usize) -> f64 {
        rows[0][c].0[0]
    }
    #[inline(always)]
    fn write_rows(value: f64, rows: &mut [&mut [Row8]; 2], c: usize) {
        rows[0][c].0[0] = value;
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
    #[inline(always)]
    fn read_rows(rows: [&[Row8]; 2], c: usize) -> L {
        L::load(&rows[0][c].0)
    }
    #[inline(always)]
    fn write_rows(value: L, rows: &mut [&mut [Row8]; 2], c: usize) {
        value.store(&mut rows[0][c].0);
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
    #[inline(always)]
    fn read_rows(rows: [&[Row8]; 2], c: usize) -> Twice<L> {
        Twice(L::load(&rows[0][c].0), L::load(&rows[1][c].0))
    }
    #[inline(always)]
    fn write_rows(value: Twice<L>, rows: &mut [&mut [Row8]; 2], c: usize) {
        value.0.store(&mut rows[0][c].0);
        value.1.store(&mut rows[1][c].0);
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
    /// The normal part of a contact: the numbers of [`super::Normal`] and the mask of touching pairs.
    pub const CONTACT: usize = 2;
    pub const TOUCHING: usize = CONTACT + 7;
    /// Energy lost by making, by breaking, and by plastic deformation.
    pub const LOSSES: usize = TOUCHING + 1;
    pub const INCREMENT: usize = LOSSES + 3;
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
    pub const ALL: usize = ACTING + 1;
}

/// The columns of a call.
pub(super) type Columns = [Column; at::ALL];

/// The arguments of the call of a law: the constants and the history of one batch or of two, and the columns.
pub struct Sheet<'a> {
    pub(super) constants: [&'a [Row8]; 2],
    pub(super) history: [&'a mut [Row8]; 2],
    pub(super) columns: &'a mut Columns,
}

impl Sheet<'_> {
    /// The constants of the law.
    #[inline(always)]
    pub(super) fn constants<W: Width>(&self) -> [W::Value; LAW_CONSTANTS] {
        let rows = [&self.constants[0][..LAW_CONSTANTS], &self.constants[1][..LAW_CONSTANTS]];
        std::array::from_fn(
            #[inline(always)]
            |c| W::read_rows(rows, c),
        )
    }

    /// The first columns of the history; the rest is zero.
    #[inline(always)]
    pub(super) fn history<W: Width, const N: usize>(&self, used: usize) -> [W::Value; N] {
        let rows = [&*self.history[0], &*self.history[1]];
        let mut history = [W::Value::zero(); N];
        for (c, value) in history.iter_mut().enumerate().take(used) {
            *value = W::read_rows(rows, c);
        }
        history
    }

    /// Writes the first columns of the history.
    #[inline(always)]
    pub(super) fn keep<W: Width, const N: usize>(&mut self, history: &[W::Value; N], used: usize) {
        for (c, value) in history.iter().enumerate().take(used) {
            W::write_rows(*value, &mut self.history, c);
        }
    }

    /// Calls for the first batch, and for the second where there are two.
    #[inline(always)]
    pub(super) fn for_each_batch(&mut self, count: Count, mut call: impl FnMut(&mut Self)) {
        call(self);
        if count == Count::TwoBatches {
            self.exchange_batches();
            call(self);
            self.exchange_batches();
        }
    }

    fn exchange_batches(&mut self) {
        self.constants.swap(0, 1);
        self.history.swap(0, 1);
        for column in self.columns.iter_mut() {
            column.swap(0, 1);
        }
    }

    /// Calls for every contact of the first batch, each in the first lane.
    pub(super) fn for_each_contact(&mut self, call: fn(&mut Sheet<'_>)) {
        let all = self.constants;
        let [first, second] = &mut self.history;
        for lane in 0..LANES {
            let mut constants = [Row8::default(); LAW_CONSTANTS];
            for (to, from) in constants.iter_mut().zip(all[0]) {
                to.0[0] = from.0[lane];
            }
            bring_to_front(lane, first, self.columns);
            call(&mut Sheet {
                constants: [&constants, all[1]],
                history: [&mut **first, &mut **second],
                columns: &mut *self.columns,
            });
            bring_to_front(lane, first, self.columns);
        }
    }
}

/// Exchanges the contact of a lane with that of the first.
fn bring_to_front(lane: usize, history: &mut [Row8], columns: &mut Columns) {
    history.iter_mut().for_each(|row| row.0.swap(0, lane));
    columns.iter_mut().for_each(|column| column[0].0.swap(0, lane));
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
